#pragma once
/// Which command frames are valid: what the receiver knows beyond a single frame's layout.

#include <cstdint>
#include <optional>

#include "can/e2e/e2e.hpp"
#include "can/frame.hpp"
#include "configuration/safety_settings.hpp"
#include "signal_map/signal_map.hpp"
#include "simulation/run_state.hpp"
#include "simulation/safety.hpp"

namespace servohil::emulator {

/// When a frame came. On one clock for all of a run.
struct FrameTime {
  std::int64_t time_ns = 0;     ///< of the governor's clock: real, or in lockstep simulated time
  std::int64_t age_ns = 0;      ///< since the kernel received it; 0 where time stands still meanwhile
  std::int64_t arrival_ns = 0;  ///< as in Command
};

/// The receiver's thread; real-time safe.
class CommandValidator {
 public:
  /// @param cycle_ms  of the governor's command: the shortest time that a change of P1 is divided by
  CommandValidator(const configuration::SafetySettings& settings, int cycle_ms) noexcept;

  /// Frames are checked end to end from now on. @param max_jump  largest step of the counter that is valid
  void Check(const can::E2eLayout& layout, unsigned max_jump) noexcept { checker_.emplace(layout, max_jump); }

  /// There is an enable signal: nothing is enabled until a frame says so.
  void AwaitEnable() noexcept { newest_.enabled = false; }

  /// The next frame of the command's message. @param demand  what it says; `why` where its P1 does not count
  simulation::FrameVerdict Judge(const can::Frame& frame, const std::optional<signal_map::Demand>& demand,
                                 signal_map::CommandRejection why, const FrameTime& time) noexcept;
  /// What another message says of enable and trip.
  void TakeCondition(const signal_map::Demand& demand, const FrameTime& time) noexcept;

  /// What the simulation is told: the newest valid command and the counts so far.
  const simulation::Command& Newest() const noexcept { return newest_; }

 private:
  simulation::FrameVerdict JudgeSequence(const can::Frame& frame) noexcept;
  simulation::FrameVerdict JudgeValue(const signal_map::Demand& demand, const FrameTime& time) const noexcept;
  bool IsStale(const FrameTime& time) const noexcept;
  double WithinLimits(double p1_psi) const noexcept;
  void Follow(double p1_psi, const FrameTime& time) noexcept;

  const configuration::SafetySettings settings_;
  const double cycle_s_;
  std::optional<can::E2eChecker> checker_;
  simulation::Command newest_;
  std::int64_t newest_time_ns_ = 0;
};

/// The validator of a run: protection and enable as the governor's messages have them. @param settings Resolved()
CommandValidator ValidatorOf(const signal_map::SignalMap& signal_map,
                             const configuration::SafetySettings& settings, int cycle_ms,
                             int max_counter_jump);

}  // namespace servohil::emulator
