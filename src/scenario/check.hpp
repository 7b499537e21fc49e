#pragma once
/// One expectation held against a run, tick by tick, in constant memory.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "scenario/scenario.hpp"

namespace servohil::scenario {

enum class Outcome : std::uint8_t { kPass, kFail, kInvalid };
const char* NameOf(Outcome outcome);  ///< "PASS"

/// What a check has found.
struct Finding {
  Outcome outcome = Outcome::kInvalid;
  bool decided = false;  ///< whatever the rest of its time may bring
  std::string text;      ///< what was measured, when, and the limit
  std::optional<double> measured{};
  std::optional<std::uint64_t> tick{};  ///< where it was broken first, or what was measured lies
};

class Check {
 public:
  virtual ~Check() = default;
  Check() = default;
  Check(const Check&) = delete;
  Check& operator=(const Check&) = delete;

  /// After each tick of scenario time, in order. @param value  of the expectation's quantity
  virtual void Take(std::uint64_t tick, double value, simulation::Mode mode) = 0;
  /// So far: kPass means that nothing was against it.
  virtual Finding Find() const = 0;
};

/// @param expectation  must outlive the check
std::unique_ptr<Check> CheckOf(const Expectation& expectation);

}  // namespace servohil::scenario
