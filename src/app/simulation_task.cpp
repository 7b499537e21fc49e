#include "servohil/app/simulation_task.hpp"

#include <algorithm>
#include <utility>

#include "servohil/rt/clock.hpp"

namespace servohil::app {

SimulationTask::SimulationTask(const model::Derived& derived, const model::SteadyState& start,
                               TaskOptions options)
    : simulation_(derived, start), options_(std::move(options)) {
  now_.sample = simulation_.Now();
}

void SimulationTask::Restore(const Snapshot& snapshot) noexcept {
  simulation_.Restore(snapshot.sample);
  command_ = snapshot.command;
  command_tick_ = snapshot.command_tick;
  now_.sample = snapshot.sample;
  now_.status.commanded = snapshot.commanded;
  first_tick_ = snapshot.sample.tick;
}

bool SimulationTask::GoesOn() const noexcept {
  return options_.duration_ticks == 0 ||
         now_.sample.tick - first_tick_ + frozen_ticks_ < options_.duration_ticks;
}

bool SimulationTask::Run(int ticks) noexcept {
  bool goes_on = GoesOn();
  for (int i = 0; i < ticks && goes_on; ++i) {
    Tick();
    Publish(now_.sample.tick);
    TakeSnapshots();
    goes_on = GoesOn();
  }
  newest_.Put(now_);
  return goes_on;
}

bool SimulationTask::Wake(const rt::LoopTiming& timing) noexcept {
  Account(timing);
  const bool overrun = IsOverrun(timing);
  if (overrun && options_.loop.overrun == Overrun::kStop) {
    newest_.Put(now_);
    return false;
  }
  const bool freezes = overrun && options_.loop.overrun == Overrun::kFreeze;
  return freezes || now_.status.mode == Mode::kFrozen ? StandStill() : Run(options_.loop.wake_ticks);
}

/// More is to be caught up than the limit allows; each time is counted once.
bool SimulationTask::IsOverrun(const rt::LoopTiming& timing) noexcept {
  const bool was_over_limit = over_limit_;
  over_limit_ = !timing.in_grace && timing.behind * static_cast<std::uint64_t>(options_.loop.wake_ticks) >
                                        static_cast<std::uint64_t>(options_.loop.max_catch_up_ticks);
  if (over_limit_ && !was_over_limit) ++now_.status.overruns;
  return over_limit_;
}

void SimulationTask::Account(const rt::LoopTiming& timing) noexcept {
  const auto ticks = [&](std::uint64_t wakes) noexcept {
    return wakes * static_cast<std::uint64_t>(options_.loop.wake_ticks);
  };
  Status& status = now_.status;
  status.late = {.woke_late = ticks(timing.late.Count(rt::LateCause::kWokeLate)),
                 .computed_long = ticks(timing.late.Count(rt::LateCause::kComputedLong)),
                 .both = ticks(timing.late.Count(rt::LateCause::kBoth)),
                 .in_grace = ticks(timing.late.CountInGrace())};
  status.worst_lateness_ns = timing.worst_lateness_ns;
  status.recent_lateness_ns = std::max(status.recent_lateness_ns, timing.lateness_ns);
}

/// Simulated time does not pass; what is due is published all the same.
bool SimulationTask::StandStill() noexcept {
  now_.status.mode = Mode::kFrozen;
  for (int i = 0; i < options_.loop.wake_ticks; ++i) Publish(now_.sample.tick + ++frozen_ticks_);
  newest_.Put(now_);
  return GoesOn();
}

void SimulationTask::TakeCommand() noexcept {
  if (!commands_.Take(command_)) return;
  Status& status = now_.status;
  status.commanded = true;
  status.command_arrival_ns = command_.arrival_ns;
  command_tick_ = now_.sample.tick;
  if (command_.arrival_ns != 0) arrival_to_tick_.Record(rt::MonotonicNs() - command_.arrival_ns);
  if (options_.recorder != nullptr) options_.recorder->RecordCommand(command_tick_ + 1, command_.p1_psi);
}

void SimulationTask::Tick() noexcept {
  TakeCommand();
  Status& status = now_.status;
  now_.sample = status.commanded ? simulation_.Tick(command_.p1_psi) : simulation_.Rest();
  status.command_age_ticks = now_.sample.tick - command_tick_;
  status.mode = now_.sample.model_fault ? Mode::kModelFault
                : status.commanded      ? Mode::kRunning
                                        : Mode::kWaiting;
  if (options_.recorder != nullptr) options_.recorder->RecordTick(now_);
}

void SimulationTask::Publish(std::uint64_t tick) noexcept {
  bool any = false;
  for (std::size_t i = 0; i < kPublishedCount; ++i) {
    now_.due[i] = options_.cycle_ticks[i] != 0 && tick % options_.cycle_ticks[i] == 0;
    any = any || now_.due[i];
  }
  if (any) telemetry_.TryPush(now_);
  if (now_.due[static_cast<std::size_t>(Published::kStatus)]) now_.status.recent_lateness_ns = 0;
}

void SimulationTask::TakeSnapshots() noexcept {
  bool wanted = snapshot_requested_.load(std::memory_order_relaxed) &&
                snapshot_requested_.exchange(false, std::memory_order_relaxed);
  const auto& ticks = options_.snapshot_ticks;
  while (next_snapshot_ < ticks.size() && ticks[next_snapshot_] <= now_.sample.tick) {
    wanted = wanted || ticks[next_snapshot_] == now_.sample.tick;
    ++next_snapshot_;
  }
  if (wanted) snapshots_.TryPush({now_.sample, command_, now_.status.commanded, command_tick_});
}

}  // namespace servohil::app
