#include "emulator/simulation_task.hpp"

#include <algorithm>
#include <utility>

#include "base/clock.hpp"

namespace servohil::emulator {

SimulationTask::SimulationTask(const model::Parameters& parameters, const model::SteadyState& start,
                               TaskOptions options)
    : simulation_(parameters, start), options_(std::move(options)), monitor_(options_.safety) {
  now_.sample = simulation_.Now();
  now_.outputs = simulation_.Outputs();
}

void SimulationTask::Restore(const Snapshot& snapshot) noexcept {
  simulation_.Restore(snapshot.sample, snapshot.faults);
  PutFaults();
  monitor_.Restore(snapshot.safety);
  command_tick_ = snapshot.command_tick;
  now_.sample = snapshot.sample;
  now_.status.commanded = snapshot.commanded;
  TakeStatus();
  first_tick_ = snapshot.sample.tick;
  first_command_tick_ = snapshot.sample.tick;
  clock_ = first_tick_;
}

bool SimulationTask::GoesOn() const noexcept {
  if (options_.duration_ticks == 0) return true;
  const bool waits = options_.is_scenario && !now_.status.commanded;
  const std::uint64_t begin = options_.is_scenario && !waits ? first_command_tick_ : first_tick_;
  return now_.sample.tick - begin + frozen_ticks_ < (waits ? options_.wait_ticks : options_.duration_ticks);
}

bool SimulationTask::Run(int ticks, bool silence_counts) noexcept {
  bool goes_on = GoesOn();
  for (int i = 0; i < ticks && goes_on; ++i) {
    Tick(silence_counts);
    Publish(now_.sample.tick);
    PublishSample();
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
  if (overrun && options_.loop.overrun == configuration::Overrun::kStop) {
    newest_.Put(now_);
    return false;
  }
  const bool freezes = overrun && options_.loop.overrun == configuration::Overrun::kFreeze;
  if (freezes || now_.status.mode == simulation::Mode::kFrozen) return PublishFrozen();
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
  simulation::Status& status = now_.status;
  status.late = {.woke_late = ticks(timing.late.Count(rt::LateCause::kWokeLate)),
                 .computed_long = ticks(timing.late.Count(rt::LateCause::kComputedLong)),
                 .both = ticks(timing.late.Count(rt::LateCause::kBoth)),
                 .in_grace = ticks(timing.late.CountInGrace())};
  status.worst_lateness_ns = timing.worst_lateness_ns;
  status.recent_lateness_ns = std::max(status.recent_lateness_ns, timing.lateness_ns);
}

/// Simulated time does not pass; what is due is published all the same.
bool SimulationTask::PublishFrozen() noexcept {
  now_.status.mode = simulation::Mode::kFrozen;
  ServeRequests();
  for (int i = 0; i < options_.loop.wake_ticks; ++i) Publish(now_.sample.tick + ++frozen_ticks_);
  newest_.Put(now_);
  return GoesOn();
}

void SimulationTask::TakeCommand() noexcept {
  simulation::Command command;
  if (!commands_.Take(command)) return;
  now_.status.frames = command.counts;
  const std::int64_t age_ns = command.arrival_ns != 0 ? base::MonotonicNs() - command.arrival_ns : 0;
  const bool fresh_enough = options_.max_age_ns == 0 || age_ns <= options_.max_age_ns;
  if (!monitor_.Hear(command, fresh_enough)) return;
  if (command.arrival_ns != 0) arrival_to_tick_.Record(age_ns);
  FollowGovernor(command.p1_psi, command.arrival_ns);
}

/// Any command, the governor's or a local one.
void SimulationTask::NoteCommand(std::int64_t arrival_ns) noexcept {
  if (!now_.status.commanded) first_command_tick_ = now_.sample.tick;
  command_tick_ = now_.sample.tick;
  now_.status.commanded = true;
  now_.status.command_arrival_ns = arrival_ns;
}

void SimulationTask::FollowGovernor(double p1_psi, std::int64_t arrival_ns) noexcept {
  monitor_.SetDemand(p1_psi);
  NoteCommand(arrival_ns);
  simulation::Request request;
  request.kind = simulation::Request::Kind::kGovernor;
  request.p1_psi = p1_psi;
  NoteStimulus(request);
}

/// Felt by the next tick for the first time.
void SimulationTask::NoteStimulus(const simulation::Request& request) noexcept {
  if (options_.recorder != nullptr) options_.recorder->RecordStimulus({now_.sample.tick + 1, request});
}

void SimulationTask::TakeFrames() noexcept {
  constexpr int kMaxAtOnce = 16;
  SeenFrame frame;
  for (int i = 0; i < kMaxAtOnce && frames_.TryPop(frame); ++i) TakeFrame(frame.id, frame.extended);
}

void SimulationTask::TakeFrame(std::uint32_t id, bool extended) noexcept {
  if (!simulation_.Faults().WaitsForFrame(id, extended)) return;
  simulation_.Faults().TakeFrame(id, extended, now_.sample.tick + 1);
  PutFaults();
  simulation::Request request;
  request.kind = simulation::Request::Kind::kFrame;
  request.injection.trigger.frame_id = id;
  request.injection.trigger.extended = extended;
  NoteStimulus(request);
}

bool SimulationTask::FollowLocal(double p1_psi) noexcept {
  const simulation::SafetyState from = monitor_.Now().state;
  if (!monitor_.TakeLocal(p1_psi)) return false;
  TellSafetyChange(from, now_.sample.tick + 1);
  NoteCommand(0);
  return true;
}

void SimulationTask::ChangeSafety(const simulation::CommandMonitor::Decision& decision) noexcept {
  const simulation::SafetyState from = monitor_.Now().state;
  monitor_.Change(decision);
  TellSafetyChange(from, now_.sample.tick + 1);
  simulation::Request request;
  request.kind = simulation::Request::Kind::kSafety;
  request.safety = decision.to;
  request.safety_cause = decision.cause;
  NoteStimulus(request);
}

void SimulationTask::TellSafetyChange(simulation::SafetyState from, std::uint64_t tick) noexcept {
  const simulation::CommandMonitorState& now = monitor_.Now();
  if (now.state != from) safety_changes_.TryPush({tick, from, now.state, now.cause});
}

void SimulationTask::Tick(bool silence_counts) noexcept {
  ServeRequests();
  TakeFrames();
  if (options_.supervised) {
    TakeCommand();
    if (const auto decision = monitor_.Decide(silence_counts)) ChangeSafety(*decision);
  }
  FollowScript();
  const double p1_psi = monitor_.P1(now_.sample.p1_psi);
  now_.sample = monitor_.Rests() ? simulation_.Rest() : simulation_.Tick(p1_psi);
  const simulation::SafetyState from = monitor_.Now().state;
  if (now_.sample.model_fault && from != simulation::SafetyState::kFaulted) {
    monitor_.Change({simulation::SafetyState::kFaulted,
                     simulation::SafetyCause::kModelFault});  // so does a replay: not recorded
    TellSafetyChange(from, now_.sample.tick);
  }
  TakeStatus();
  ObserveFaults();
  TellFaults();
  if (options_.recorder != nullptr) options_.recorder->RecordTick(now_);
  if (options_.feed != nullptr) options_.feed->Put(now_);
  if (options_.stall == nullptr) return;
  const fault::Stall stall = fault::StallAt(simulation_.Faults(), now_.sample.tick);
  if (stall.ms > 0.0) options_.stall(stall.ms);
}

void SimulationTask::TakeStatus() noexcept {
  constexpr simulation::Mode kModes[] = {simulation::Mode::kWaiting, simulation::Mode::kRunning,
                                         simulation::Mode::kDegraded, simulation::Mode::kTripped,
                                         simulation::Mode::kModelFault};
  const simulation::CommandMonitorState& safety = monitor_.Now();
  simulation::Status& status = now_.status;
  status.command_age_ticks = now_.sample.tick - command_tick_;
  status.active_faults = simulation_.Faults().CountActive(now_.sample.tick);
  status.line_down = fault::LineAt(simulation_.Faults(), now_.sample.tick).down;
  status.safety = safety.state;
  status.safety_cause = safety.cause;
  status.losses = safety.losses;
  status.trips = safety.trips;
  status.mode = kModes[static_cast<std::size_t>(safety.state)];
}

/// All quantities, of which there are outputs now.
std::span<const double> SimulationTask::Truth(
    std::array<double, simulation::kMaxQuantities>& values) const noexcept {
  const std::span<const simulation::Quantity> quantities = simulation::Quantities();
  for (std::size_t i = 0; i < quantities.size(); ++i) values[i] = quantities[i].value(now_);
  return {values.data(), quantities.size()};
}

void SimulationTask::ObserveFaults() noexcept {
  fault::Schedule& faults = simulation_.Faults();
  const std::uint64_t tick = now_.sample.tick;
  const bool sensors_act = fault::Sensors::Act(faults, tick);
  if (!sensors_act && !faults.Observes()) return;
  now_.outputs = simulation_.Outputs();
  std::array<double, simulation::kMaxQuantities> values{};
  const std::span<const double> truth = Truth(values);
  faults.Observe(tick, truth);
  if (sensors_act) sensors_->Observe(faults, tick, truth);
}

void SimulationTask::TellFaults() noexcept {
  fault::Schedule& faults = simulation_.Faults();
  if (faults.Events().empty()) return;
  for (const fault::Event& event : faults.Events()) {
    fault_events_.TryPush(event);
    if (options_.recorder != nullptr) options_.recorder->RecordFaultEvent(event);
  }
  faults.ForgetEvents();
  PutFaults();
}

void SimulationTask::PutFaults() noexcept {
  faults_.Put(simulation_.Faults());
  faults_of_receiver_.Put(simulation_.Faults());
  faults_of_sender_.Put(simulation_.Faults());
}

/// For those who have subscribed on the control socket.
void SimulationTask::PublishSample() noexcept {
  const std::uint64_t every = sample_ticks_.load(std::memory_order_relaxed);
  if (every == 0 || now_.sample.tick % every != 0) return;
  now_.outputs = simulation_.Outputs();
  samples_.TryPush(now_);
}

void SimulationTask::Publish(std::uint64_t tick) noexcept {
  now_.due = 0;
  for (std::size_t i = 0; i < simulation::kMaxMessages && options_.cycle_ticks[i] != 0; ++i) {
    if (tick % options_.cycle_ticks[i] == 0) now_.due |= simulation::SetOf(i);
  }
  clock_.store(tick, std::memory_order_relaxed);
  if (now_.due != 0) {
    now_.outputs = simulation_.Outputs();
    PublishDue();
  }
  if ((now_.due & options_.tell_lateness) != 0) now_.status.recent_lateness_ns = 0;
}

/// As one where all frames have the same fate.
void SimulationTask::PublishDue() noexcept {
  const fault::Schedule& faults = simulation_.Faults();
  if (!fault::ActsOnPublished(faults, Clock())) {
    publications_.TryPush(PublicationNow(simulation::kMaxMessages));
    return;
  }
  for (std::size_t i = 0; i < simulation::kMaxMessages; ++i) {
    if (!simulation::Has(now_.due, i)) continue;
    simulation::Publication publication = PublicationNow(i);
    publication.run_state.due = simulation::SetOf(i);
    publications_.TryPush(publication);
  }
}

simulation::Publication SimulationTask::PublicationNow(std::size_t message) const noexcept {
  const fault::Schedule& faults = simulation_.Faults();
  simulation::Publication publication{now_, {}, {}};
  if (message < simulation::kMaxMessages)
    publication.fate = fault::FateOfPublished(faults, static_cast<std::uint8_t>(message), Clock());
  const std::uint64_t tick = now_.sample.tick;
  if (!fault::Sensors::Act(faults, tick)) return publication;
  std::array<double, simulation::kMaxQuantities> values{};
  const std::span<const double> truth = Truth(values);
  simulation::Measured& measured = publication.measured;
  sensors_->Measure(faults, tick, truth, measured.values);
  for (std::size_t i = 0; i < truth.size(); ++i)
    measured.changed |= std::uint64_t{measured.values[i] != truth[i]} << i;
  return publication;
}

void SimulationTask::TakeDueSnapshots() noexcept {
  const auto& ticks = options_.snapshot_ticks;
  while (next_snapshot_ < ticks.size() && ticks[next_snapshot_] <= now_.sample.tick) {
    if (ticks[next_snapshot_] == now_.sample.tick) TakeSnapshot();
    ++next_snapshot_;
  }
}

bool SimulationTask::TakeSnapshot() noexcept {
  if (fault::Sensors::Remember(simulation_.Faults())) {
    snapshots_refused_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  snapshots_.TryPush(
      {now_.sample, monitor_.Now(), now_.status.commanded, command_tick_, simulation_.Faults()});
  return true;
}

void SimulationTask::ServeRequests() noexcept {
  constexpr int kMaxAtOnce = 4;
  simulation::Request request;
  for (int i = 0; i < kMaxAtOnce && requests_.TryPop(request); ++i) answers_.TryPush(Serve(request));
  for (int i = 0; i < kMaxAtOnce && bus_requests_.TryPop(request); ++i) bus_answers_.TryPush(Serve(request));
}

void SimulationTask::FollowScript() noexcept {
  const auto& script = options_.script;
  while (now_.status.commanded && next_script_ < script.size() &&
         first_command_tick_ + script[next_script_].tick <= now_.sample.tick + 1) {
    const simulation::Answer answer = Serve(script[next_script_++].request);
    if (answer.result == simulation::Answer::Result::kNoRoom) ++script_refused_;
  }
}

simulation::Answer SimulationTask::Serve(const simulation::Request& request) noexcept {
  const std::uint64_t next_tick = now_.sample.tick + 1;
  fault::Schedule& faults = simulation_.Faults();
  simulation::Answer answer{request.number, simulation::Answer::Result::kApplied, next_tick};
  if (now_.status.mode == simulation::Mode::kFrozen && request.kind != simulation::Request::Kind::kSnapshot) {
    answer.result = simulation::Answer::Result::kFrozen;
    return answer;
  }
  switch (request.kind) {
    case simulation::Request::Kind::kInject: {
      fault::Injection injection = request.injection;
      injection.start_tick = std::max(injection.start_tick, next_tick);
      answer.tick = injection.start_tick;
      if (!faults.Inject(injection, next_tick)) answer.result = simulation::Answer::Result::kNoRoom;
      break;
    }
    case simulation::Request::Kind::kClear:
      if (faults.Clear(request.injection.id, request.injection.target, next_tick) == 0)
        answer.result = simulation::Answer::Result::kNoSuchFault;
      break;
    case simulation::Request::Kind::kClearAll:
      faults.ClearAll(next_tick);
      break;
    case simulation::Request::Kind::kCommand:
      if (!FollowLocal(request.p1_psi)) answer.result = simulation::Answer::Result::kNotFollowed;
      break;
    case simulation::Request::Kind::kGovernor:
      FollowGovernor(request.p1_psi, 0);
      break;
    case simulation::Request::Kind::kSafety:
      ChangeSafety({request.safety, request.safety_cause});
      break;
    case simulation::Request::Kind::kSnapshot:
      answer.tick = now_.sample.tick;
      if (!TakeSnapshot()) answer.result = simulation::Answer::Result::kNoSnapshot;
      break;
    case simulation::Request::Kind::kFrame:
      TakeFrame(request.injection.trigger.frame_id, request.injection.trigger.extended);
      break;
  }
  const bool on_faults = request.kind == simulation::Request::Kind::kInject ||
                         request.kind == simulation::Request::Kind::kClear ||
                         request.kind == simulation::Request::Kind::kClearAll;
  if (on_faults) PutFaults();
  // The governor's, the supervision's and frames record themselves.
  const bool is_influence = on_faults || (request.kind == simulation::Request::Kind::kCommand &&
                                          answer.result == simulation::Answer::Result::kApplied);
  if (is_influence) NoteStimulus(request);
  return answer;
}

}  // namespace servohil::emulator
