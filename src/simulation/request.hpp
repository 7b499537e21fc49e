#pragma once
/// Requests to a running simulation and its answers: they cross threads.

#include <cstdint>

#include "fault/schedule.hpp"
#include "simulation/safety.hpp"

namespace servohil::simulation {

/// What somebody asks of a running simulation. Checked already: names, ranges, what the model supports.
struct Request {
  enum class Kind : std::uint8_t {
    kInject = 0,
    kClear = 1,
    kClearAll = 2,
    kCommand = 3,  ///< P1 set locally
    kSnapshot = 4,
    kFrame = 5,     ///< a frame that a fault waits for has come
    kGovernor = 6,  ///< recordings: a valid command frame
    kSafety = 7,    ///< recordings: the supervision came to another state
  };

  std::uint64_t number = 0;  ///< whoever asks gets it back
  Kind kind = Kind::kInject;
  fault::Injection injection{};  ///< kInject: start_tick 0 is now; kClear: its id and target; kFrame: trigger
  double p1_psi = 0.0;           ///< kCommand, kGovernor
  SafetyState safety = SafetyState::kWaiting;     ///< kSafety
  SafetyCause safety_cause = SafetyCause::kNone;  ///< kSafety
};

/// The simulation's answer.
struct Answer {
  enum class Result : std::uint8_t { kApplied, kNoRoom, kNoSuchFault, kFrozen, kNoSnapshot, kNotFollowed };

  std::uint64_t number = 0;
  Result result = Result::kApplied;
  std::uint64_t tick = 0;  ///< the first that feels it, or may: a fault with a trigger waits from then on
};

}  // namespace servohil::simulation
