#pragma once
/// What the simulation thread tells the others: plain structs that cross threads.

#include <cstddef>
#include <cstdint>

#include "can/bus_condition.hpp"
#include "model/servomotor.hpp"
#include "simulation/safety.hpp"
#include "simulation/sample.hpp"

namespace servohil::simulation {

/// The newest valid command frame of the governor, and what came with and before it: whoever sees only the
/// newest still knows how many there were.
struct Command {
  double p1_psi = 0.0;
  bool enabled = true;  ///< can.command.enable; always where there is none
  bool trip = false;    ///< can.command.trip
  std::int64_t arrival_ns =
      0;                   ///< CLOCK_MONOTONIC, by the kernel's receive stamp where there is one; 0: unknown
  FrameCounts counts;      ///< of all frames so far
  std::uint64_t good = 0;  ///< valid, enabled, without trip, so far
  std::uint64_t good_in_a_row = 0;  ///< since the last that was not
  std::uint64_t trips = 0;          ///< valid with trip, so far
  std::uint64_t disablings = 0;     ///< valid and not enabled, so far
};

/// State machine of a run, signal Mode of SERVO_Status.
enum class Mode : std::uint8_t {
  kWaiting = 0,  ///< at rest at the start position until the first command
  kRunning = 1,
  kModelFault = 2,  ///< the model left its domain: the last good state is published
  kStopped = 3,     ///< the last status before the program ends
  kFrozen = 4,      ///< overrun policy "freeze": the last state is published, simulated time stands still
  kDegraded = 5,    ///< the command is lost or not enabled: safety.on_loss
  kTripped = 6,     ///< P1 is drained at once
};
/// As in the statistics and the DBC: "WAITING".
const char* NameOf(Mode mode);

/// Late: began a wake period or more after its deadline. None outside real time.
struct LateTicks {
  std::uint64_t woke_late = 0;
  std::uint64_t computed_long = 0;
  std::uint64_t both = 0;
  std::uint64_t in_grace = 0;  ///< during the start-up grace: not among the others

  std::uint64_t Total() const noexcept { return woke_late + computed_long + both; }
};

struct Status {
  Mode mode = Mode::kWaiting;
  LateTicks late;
  std::uint64_t overruns = 0;           ///< times that more had to be caught up than loop.max_catch_up_ticks
  std::int64_t worst_lateness_ns = 0;   ///< since the start
  std::int64_t recent_lateness_ns = 0;  ///< worst since the status message before
  bool commanded = false;               ///< a command has been received
  std::uint64_t command_age_ticks = 0;
  std::uint64_t active_faults = 0;      ///< injected ones that act now
  bool line_down = false;               ///< by the fault interface_down: as if unplugged
  std::int64_t command_arrival_ns = 0;  ///< of the newest command, as in Command
  SafetyState safety = SafetyState::kWaiting;
  SafetyCause safety_cause = SafetyCause::kNone;
  std::uint64_t losses = 0;  ///< times that the command was lost or not enabled any more
  std::uint64_t trips = 0;
  FrameCounts frames;  ///< with the command's identifier

  /// No late tick since the start; latched.
  bool TimingValid() const noexcept { return late.Total() == 0; }
};

/// Messages that the emulator publishes, as numbers: the signal_map has their list.
inline constexpr std::size_t kMaxMessages = 32;
/// Some of them: bit i is message i.
using MessageSet = std::uint32_t;
inline constexpr MessageSet SetOf(std::size_t message) noexcept {
  return MessageSet{1} << message;
}
inline constexpr bool Has(MessageSet set, std::size_t message) noexcept {
  return (set >> message & 1U) != 0;
}

struct RunState {
  Sample sample;
  Status status;
  model::Outputs outputs{};  ///< at a tick where something is due, and after the last of a run of ticks
  MessageSet due = 0;        ///< messages whose cycle ends at this tick
  can::BusCondition bus;     ///< filled in by the sender
};

}  // namespace servohil::simulation
