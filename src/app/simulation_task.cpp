#include "servohil/app/simulation_task.hpp"

#include <algorithm>
#include <utility>

#include "servohil/rt/clock.hpp"

namespace servohil::app {

SimulationTask::SimulationTask(const model::Parameters& parameters, const model::SteadyState& start,
                               TaskOptions options)
    : simulation_(parameters, start), options_(std::move(options)), supervisor_(options_.safety) {
  now_.sample = simulation_.Now();
  now_.outputs = simulation_.Outputs();
}

void SimulationTask::Restore(const Snapshot& snapshot) noexcept {
  simulation_.Restore(snapshot.sample, snapshot.faults);
  faults_.Put(snapshot.faults);
  supervisor_.Restore(snapshot.safety);
  command_tick_ = snapshot.command_tick;
  now_.sample = snapshot.sample;
  now_.status.commanded = snapshot.commanded;
  TakeStatus();
  first_tick_ = snapshot.sample.tick;
}

bool SimulationTask::GoesOn() const noexcept {
  return options_.duration_ticks == 0 ||
         now_.sample.tick - first_tick_ + frozen_ticks_ < options_.duration_ticks;
}

bool SimulationTask::Run(int ticks, bool silence_counts) noexcept {
  bool goes_on = GoesOn();
  for (int i = 0; i < ticks && goes_on; ++i) {
    Tick(silence_counts);
    Publish(now_.sample.tick);
    TakeDueSnapshots();
    goes_on = GoesOn();
  }
  now_.outputs = simulation_.Outputs();
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
  if (freezes || now_.status.mode == Mode::kFrozen) return StandStill();
  // Late itself, the emulator cannot know whether the governor is: what it missed waits to be read.
  return Run(options_.loop.wake_ticks, timing.behind == 0);
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
  ServeRequests();
  for (int i = 0; i < options_.loop.wake_ticks; ++i) Publish(now_.sample.tick + ++frozen_ticks_);
  newest_.Put(now_);
  return GoesOn();
}

void SimulationTask::TakeCommand() noexcept {
  Command command;
  if (!commands_.Take(command)) return;
  now_.status.frames = command.counts;
  const std::int64_t age_ns = command.arrival_ns != 0 ? rt::MonotonicNs() - command.arrival_ns : 0;
  const bool fresh_enough = options_.max_age_ns == 0 || age_ns <= options_.max_age_ns;
  if (!supervisor_.Hear(command, fresh_enough)) return;
  if (command.arrival_ns != 0) arrival_to_tick_.Record(age_ns);
  now_.status.command_arrival_ns = command.arrival_ns;
  FollowGovernor(command.p1_psi);
}

void SimulationTask::FollowGovernor(double p1_psi) noexcept {
  supervisor_.SetDemand(p1_psi);
  command_tick_ = now_.sample.tick;
  now_.status.commanded = true;
  Request request;
  request.kind = Request::Kind::kGovernor;
  request.p1_psi = p1_psi;
  Record(request);
}

bool SimulationTask::FollowLocal(double p1_psi) noexcept {
  const SafetyState from = supervisor_.Now().state;
  if (!supervisor_.TakeLocal(p1_psi)) return false;
  TellSafetyChange(from, now_.sample.tick + 1);
  command_tick_ = now_.sample.tick;
  now_.status.commanded = true;
  now_.status.command_arrival_ns = 0;
  return true;
}

void SimulationTask::ChangeSafety(const Supervisor::Decision& decision) noexcept {
  const SafetyState from = supervisor_.Now().state;
  supervisor_.Change(decision);
  TellSafetyChange(from, now_.sample.tick + 1);
  Request request;
  request.kind = Request::Kind::kSafety;
  request.safety = decision.to;
  request.safety_cause = decision.cause;
  Record(request);
}

void SimulationTask::TellSafetyChange(SafetyState from, std::uint64_t tick) noexcept {
  const SupervisorState& now = supervisor_.Now();
  if (now.state != from) safety_changes_.TryPush({tick, from, now.state, now.cause});
}

/// With effect from the next tick on.
void SimulationTask::Record(const Request& request) noexcept {
  if (options_.recorder != nullptr) options_.recorder->RecordInfluence({now_.sample.tick + 1, request});
}

void SimulationTask::Tick(bool silence_counts) noexcept {
  ServeRequests();
  if (options_.supervised) {
    TakeCommand();
    if (const auto decision = supervisor_.Decide(silence_counts)) ChangeSafety(*decision);
  }
  const double p1_psi = supervisor_.P1(now_.sample.p1_psi);
  now_.sample = supervisor_.Rests() ? simulation_.Rest() : simulation_.Tick(p1_psi);
  const SafetyState from = supervisor_.Now().state;
  if (now_.sample.model_fault && from != SafetyState::kFaulted) {
    supervisor_.Change({SafetyState::kFaulted, SafetyCause::kModelFault});  // so does a replay: not recorded
    TellSafetyChange(from, now_.sample.tick);
  }
  TakeStatus();
  if (options_.recorder != nullptr) options_.recorder->RecordTick(now_);
}

void SimulationTask::TakeStatus() noexcept {
  constexpr Mode kModes[] = {Mode::kWaiting, Mode::kRunning, Mode::kDegraded, Mode::kTripped,
                             Mode::kModelFault};
  const SupervisorState& safety = supervisor_.Now();
  Status& status = now_.status;
  status.command_age_ticks = now_.sample.tick - command_tick_;
  status.active_faults = simulation_.Faults().CountActive(now_.sample.tick);
  status.safety = safety.state;
  status.safety_cause = safety.cause;
  status.losses = safety.losses;
  status.trips = safety.trips;
  status.mode = kModes[static_cast<std::size_t>(safety.state)];
}

void SimulationTask::Publish(std::uint64_t tick) noexcept {
  now_.due = 0;
  for (std::size_t i = 0; i < kMostMessages && options_.cycle_ticks[i] != 0; ++i) {
    if (tick % options_.cycle_ticks[i] == 0) now_.due |= SetOf(i);
  }
  if (now_.due != 0) {
    now_.outputs = simulation_.Outputs();
    telemetry_.TryPush(now_);
  }
  if ((now_.due & options_.tell_lateness) != 0) now_.status.recent_lateness_ns = 0;
}

void SimulationTask::TakeDueSnapshots() noexcept {
  const auto& ticks = options_.snapshot_ticks;
  while (next_snapshot_ < ticks.size() && ticks[next_snapshot_] <= now_.sample.tick) {
    if (ticks[next_snapshot_] == now_.sample.tick) TakeSnapshot();
    ++next_snapshot_;
  }
}

void SimulationTask::TakeSnapshot() noexcept {
  snapshots_.TryPush(
      {now_.sample, supervisor_.Now(), now_.status.commanded, command_tick_, simulation_.Faults()});
}

void SimulationTask::ServeRequests() noexcept {
  constexpr int kMostAtOnce = 4;
  Request request;
  for (int i = 0; i < kMostAtOnce && requests_.TryPop(request); ++i) Serve(request);
}

void SimulationTask::Serve(const Request& request) noexcept {
  const std::uint64_t next_tick = now_.sample.tick + 1;
  fault::Schedule& faults = simulation_.Faults();
  Answer answer{request.number, Answer::Result::kApplied, next_tick};
  if (now_.status.mode == Mode::kFrozen && request.kind != Request::Kind::kSnapshot) {
    answer.result = Answer::Result::kFrozen;
    answers_.TryPush(answer);
    return;
  }
  switch (request.kind) {
    case Request::Kind::kInject: {
      fault::Injection injection = request.injection;
      injection.start_tick = std::max(injection.start_tick, next_tick);
      answer.tick = injection.start_tick;
      if (!faults.Inject(injection)) answer.result = Answer::Result::kNoRoom;
      break;
    }
    case Request::Kind::kClear:
      if (faults.Clear(request.injection.id) == 0) answer.result = Answer::Result::kNoSuchFault;
      break;
    case Request::Kind::kClearAll:
      faults.ClearAll();
      break;
    case Request::Kind::kCommand:
      if (!FollowLocal(request.p1_psi)) answer.result = Answer::Result::kNotFollowed;
      break;
    case Request::Kind::kGovernor:
      FollowGovernor(request.p1_psi);
      break;
    case Request::Kind::kSafety:
      ChangeSafety({request.safety, request.safety_cause});
      break;
    case Request::Kind::kSnapshot:
      answer.tick = now_.sample.tick;
      TakeSnapshot();
      break;
  }
  faults_.Put(faults);
  answers_.TryPush(answer);
  // The governor's and the supervision's record themselves.
  const bool is_influence =
      request.kind == Request::Kind::kInject || request.kind == Request::Kind::kClear ||
      request.kind == Request::Kind::kClearAll ||
      (request.kind == Request::Kind::kCommand && answer.result == Answer::Result::kApplied);
  if (is_influence) Record(request);
}

}  // namespace servohil::app
