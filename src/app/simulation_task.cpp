#include <algorithm>

#include "servohil/app/emulator.hpp"

namespace servohil::app {

SimulationTask::SimulationTask(const model::Derived& derived, const model::SteadyState& start,
                               const Contract& contract, const EmulatorOptions& options) noexcept
    : simulation_(derived, start),
      wake_ticks_(options.loop.wake_ticks),
      duration_ticks_(options.duration_ticks) {
  now_.sample = simulation_.Now();
  for (std::size_t i = 0; i < kPublishedCount; ++i)
    cycle_ticks_[i] = contract.CycleTicks(static_cast<Published>(i));
}

bool SimulationTask::Wake(const rt::LoopTiming& timing) noexcept {
  now_.status.late_ticks = timing.late_wakes * static_cast<std::uint64_t>(wake_ticks_);
  now_.status.timing_valid = timing.late_wakes == 0;
  now_.status.worst_lateness_ns = timing.worst_lateness_ns;
  bool go_on = true;
  for (int i = 0; i < wake_ticks_ && go_on; ++i) {
    Tick();
    Publish();
    go_on = duration_ticks_ == 0 || now_.sample.tick < duration_ticks_;
  }
  newest_.Put(now_);
  return go_on;
}

void SimulationTask::Tick() noexcept {
  Status& status = now_.status;
  if (commands_.Take(command_)) {
    status.commanded = true;
    command_tick_ = simulation_.Now().tick;
  }
  now_.sample = status.commanded ? simulation_.Tick(command_.p1_psi) : simulation_.Rest();
  status.command_age_ticks = now_.sample.tick - command_tick_;
  status.mode = now_.sample.model_fault ? Mode::kModelFault
                : status.commanded      ? Mode::kRunning
                                        : Mode::kWaiting;
}

void SimulationTask::Publish() noexcept {
  bool any = false;
  for (std::size_t i = 0; i < kPublishedCount; ++i) {
    now_.due[i] = cycle_ticks_[i] != 0 && now_.sample.tick % cycle_ticks_[i] == 0;
    any = any || now_.due[i];
  }
  if (any) telemetry_.TryPush(now_);
}

}  // namespace servohil::app
