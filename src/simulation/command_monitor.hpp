#pragma once
/// Supervision of the governor's command: a state machine in the time of the ticks. What it decides by what
/// the bus brought (or did not) is recorded; a replay gives it the decisions and lets it decide nothing.
///
/// In the state
///   waiting              the servomotor is at rest
///   running              P1 is the newest valid command's
///   degraded, on_loss    drain: P1 falls to 0, P1' = −P1/τ, by implicit Euler per tick (rate exact to 0.1
///   ms/2τ,
///                        the same bits on every machine); hold: P1 stays; freeze: the model's state stays,
///                        time passes
///   tripped              P1 falls to 0 likewise, with a time constant of its own
///   faulted              the model's last good state stays

#include <cstdint>
#include <optional>

#include "configuration/safety_settings.hpp"
#include "simulation/run_state.hpp"
#include "simulation/safety.hpp"

namespace servohil::simulation {

/// The settings, in ticks.
struct SafetyLaw {
  std::uint64_t timeout_ticks = 0;  ///< 0: silence does not matter
  configuration::OnLoss on_loss = configuration::OnLoss::kDrain;
  double drain_factor = 0.0;  ///< of P1, per tick
  double trip_factor = 0.0;
  std::uint64_t recover_after = 1;
};

SafetyLaw LawOf(const configuration::SafetySettings& settings) noexcept;

/// All that the future of a supervision depends on besides law and inputs. Trivially copyable.
struct CommandMonitorState {
  SafetyState state = SafetyState::kWaiting;
  SafetyCause cause = SafetyCause::kNone;
  double demand_psi = 0.0;         ///< newest valid command
  bool governed = false;           ///< that was the governor's: its silence matters
  std::uint64_t silent_ticks = 0;  ///< since the newest valid frame, those that count
  std::uint64_t losses = 0;        ///< times that it came from running to degraded
  std::uint64_t trips = 0;         ///< times that it came to tripped
};

/// The thread that runs the ticks; real-time safe.
class CommandMonitor {
 public:
  explicit CommandMonitor(const SafetyLaw& law) noexcept : law_(law) {}

  const CommandMonitorState& Now() const noexcept { return now_; }
  void Restore(const CommandMonitorState& state) noexcept { now_ = state; }

  /// The newest that the receiver knows. @param fresh_enough  false: too old to be followed
  /// @return whether it brings a valid command: SetDemand() is then to follow
  bool Hear(const Command& newest, bool fresh_enough) noexcept;

  struct Decision {
    SafetyState to;
    SafetyCause cause;
  };
  /// Once a tick, after Hear(): Change() is to follow. @param counts  whether this tick's time counts as
  /// silence: not while the emulator itself is late
  std::optional<Decision> Decide(bool counts) noexcept;

  // What a replay does as well:
  void SetDemand(double p1_psi) noexcept;
  void Change(const Decision& decision) noexcept;
  /// P1 set locally: follows it at once, until the governor's next valid frame. @return false: tripped or
  /// faulted
  bool TakeLocal(double p1_psi) noexcept;

  /// Whether the model's state stays during this tick.
  bool Rests() const noexcept;
  /// P1 during this tick [psi]. @param p1_psi  of the tick before
  double P1(double p1_psi) const noexcept;

 private:
  std::optional<Decision> WhileWaiting(bool fresh, bool trips) const noexcept;
  std::optional<Decision> WhileRunning(bool trips, bool disabled) const noexcept;
  std::optional<Decision> WhileStopped(bool trips) noexcept;
  bool IsSilent() const noexcept;

  SafetyLaw law_;
  CommandMonitorState now_;
  // Of this process' frames; a replay has none.
  Command heard_;
  bool fresh_ = false;  ///< a valid frame since the tick before
  std::uint64_t trips_seen_ = 0;
  std::uint64_t disablings_seen_ = 0;
  std::uint64_t rejected_at_valid_ = 0;  ///< when the newest valid one came
  std::uint64_t good_at_begin_ = 0;      ///< of the count for recovery
};

}  // namespace servohil::simulation
