#pragma once
/// What the simulation thread tells the others: plain structs that cross threads.

#include <array>
#include <cstddef>
#include <cstdint>

#include "servohil/app/simulation.hpp"

namespace servohil::app {

/// A valid command frame of the governor.
struct Command {
  double p1_psi = 0.0;
};

/// State machine of a run, signal Mode of SERVO_Status.
enum class Mode : std::uint8_t {
  kWaiting = 0,  ///< at rest at the start position until the first command
  kRunning = 1,
  kModelFault = 2,  ///< the model left its domain: the last good state is published
  kStopped = 3,     ///< the last status before the program ends
};

struct Status {
  Mode mode = Mode::kWaiting;
  bool timing_valid = true;  ///< no late tick since the start; latched
  std::uint64_t late_ticks = 0;
  std::int64_t worst_lateness_ns = 0;
  bool commanded = false;  ///< a command has been received
  std::uint64_t command_age_ticks = 0;
};

/// Messages that the emulator publishes, in the order of their table in contract.cpp.
enum class Published : std::uint8_t { kPosition, kPressures, kRelay, kStatus };
inline constexpr std::size_t kPublishedCount = 4;

struct Telemetry {
  Sample sample;
  Status status;
  std::array<bool, kPublishedCount> due{};  ///< messages whose cycle ends at this tick
};

}  // namespace servohil::app
