#pragma once
/// Whether, and when, the emulator's mode is a certain one.

#include "scenario/check.hpp"

namespace servohil::scenario {

/// kModeBecomes, kModeNever.
class ModeCheck : public Check {
 public:
  explicit ModeCheck(const Expectation& expectation) : expectation_(expectation) {}
  void Take(std::uint64_t tick, double value, simulation::Mode mode) override;
  Finding Find() const override;

 private:
  const Expectation& expectation_;
  bool before_ = false;                 ///< it was so when the time began
  std::optional<std::uint64_t> first_;  ///< tick at which it was so, within the time
  simulation::Mode last_ = simulation::Mode::kWaiting;
};

}  // namespace servohil::scenario
