#pragma once
/// The simulation thread's work, without the thread and without a clock: "run n ticks", whoever says so. The
/// real-time loop says it at each wake-up, lockstep at each frame, a script or a replay as fast as it goes.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "configuration/configuration.hpp"
#include "fault/effects.hpp"
#include "fault/sensors.hpp"
#include "recording/recorder.hpp"
#include "rt/latency_histogram.hpp"
#include "rt/mailbox.hpp"
#include "rt/periodic_loop.hpp"
#include "rt/ring.hpp"
#include "simulation/command_monitor.hpp"
#include "simulation/publication.hpp"
#include "simulation/request.hpp"
#include "simulation/run_state.hpp"
#include "simulation/sample_feed.hpp"
#include "simulation/simulation.hpp"

namespace servohil::emulator {

/// All that a run's future depends on besides its configuration and inputs. Trivially copyable.
struct Snapshot {
  simulation::Sample sample;
  simulation::CommandMonitorState safety;
  bool commanded = false;
  std::uint64_t command_tick = 0;  ///< after which it arrived
  fault::Schedule faults;
};

struct TaskOptions {
  configuration::LoopSettings loop;
  std::array<std::uint64_t, simulation::kMaxMessages>
      cycle_ticks{};  ///< of each message that is published; 0: never
  simulation::MessageSet tell_lateness =
      0;                             ///< messages that carry the worst lateness since they did so before
  std::uint64_t duration_ticks = 0;  ///< of this run; 0: without end
  std::vector<std::uint64_t> snapshot_ticks;  ///< rising
  simulation::SafetyLaw safety;
  /// Whether the supervision decides by the commands and their silence. Not where all comes from a script or
  /// a recording, decisions included.
  bool supervised = true;
  std::int64_t max_age_ns = 0;              ///< of a command when a tick takes it; 0: any
  recording::Recorder* recorder = nullptr;  ///< must outlive the task; none: nothing is recorded
  void (*stall)(double ms) noexcept =
      nullptr;  ///< of the fault missed_ticks; none: there is no deadline to miss

  // Of a scenario, whose time begins with the first command.
  bool is_scenario = false;                 ///< duration_ticks count from then on
  std::uint64_t wait_ticks = 0;             ///< the run ends after so many without a command
  std::vector<recording::Stimulus> script;  ///< faults; tick 1 is the first that has a command
  simulation::SampleFeed* feed = nullptr;   ///< gets every tick; must outlive the task; none: nobody looks
};

class SimulationTask {
 public:
  /// At rest at `start`, tick 0.
  SimulationTask(const model::Parameters& parameters, const model::SteadyState& start, TaskOptions options);

  /// Before the first tick: goes on from `snapshot`, bit for bit as if it had never ended.
  void Restore(const Snapshot& snapshot) noexcept;

  /// Any one thread: the newest that the receiver knows. Real-time safe.
  void PutCommand(const simulation::Command& command) noexcept { commands_.Put(command); }

  /// Any one thread: what is asked, in order. @return false: too many wait
  bool PutRequest(const simulation::Request& request) noexcept { return requests_.TryPush(request); }
  /// The same thread: an answer, in order.
  bool TryPopAnswer(simulation::Answer& answer) noexcept { return answers_.TryPop(answer); }
  /// The same thread: the faults, when they have changed since the last call.
  bool TakeFaults(fault::Schedule& faults) noexcept { return faults_.Take(faults); }
  /// The same thread: what has happened to them.
  bool TryPopFaultEvent(fault::Event& event) noexcept { return fault_events_.TryPop(event); }
  /// Any thread: snapshots not taken, because a fault acts whose past they could not hold.
  std::uint64_t SnapshotsRefused() const noexcept {
    return snapshots_refused_.load(std::memory_order_relaxed);
  }

  /// The receiver: faults, when they have changed since the last call. Real-time safe.
  bool TakeFaultsOfReceiver(fault::Schedule& faults) noexcept { return faults_of_receiver_.Take(faults); }
  /// The receiver: a frame that a fault waits for has come. Real-time safe.
  void PutFrame(std::uint32_t id, bool extended) noexcept { frames_.TryPush({id, extended}); }
  /// The sender: faults, when they have changed since the last call. Real-time safe.
  bool TakeFaultsOfSender(fault::Schedule& faults) noexcept { return faults_of_sender_.Take(faults); }
  /// Any thread: ticks that have passed, those of a frozen simulation included. Real-time safe.
  std::uint64_t Clock() const noexcept { return clock_.load(std::memory_order_relaxed); }

  /// The receiver: what FAULT_Request frames ask, in order. @return false: too many wait. Real-time safe.
  bool PutBusRequest(const simulation::Request& request) noexcept { return bus_requests_.TryPush(request); }
  /// The sender: the answers, in order. Real-time safe.
  bool TryPopBusAnswer(simulation::Answer& answer) noexcept { return bus_answers_.TryPop(answer); }

  /// The thread that runs the ticks, between them: follows what is asked, with effect from the next tick on.
  /// Run() does so itself before each tick. Real-time safe.
  void ServeRequests() noexcept;

  /// Runs `ticks` ticks, each with the newest command. @param silence_counts  whether their time is time in
  /// which a command could have come. @return false after the last of the duration. Real-time safe.
  bool Run(int ticks, bool silence_counts = true) noexcept;

  /// One wake-up of the real-time loop: takes account of its lateness, follows the overrun policy, runs
  /// `loop.wake_ticks` ticks. @return false when the run ends. Real-time safe.
  bool Wake(const rt::LoopTiming& timing) noexcept;

  /// The sender: what is due, oldest first. Real-time safe.
  bool TryPopPublication(simulation::Publication& publication) noexcept {
    return publications_.TryPop(publication);
  }
  std::uint64_t PublicationsDropped() const noexcept { return publications_.Dropped(); }
  /// Whoever watches (one thread): the newest state.
  bool TakeNewest(simulation::RunState& run_state) noexcept { return newest_.Take(run_state); }

  /// Whoever watches (the same thread): changes of the supervision, oldest first.
  bool TryPopSafetyChange(simulation::SafetyChange& change) noexcept {
    return safety_changes_.TryPop(change);
  }

  /// Whoever writes them down (one thread).
  bool TryPopSnapshot(Snapshot& snapshot) noexcept { return snapshots_.TryPop(snapshot); }

  /// Any thread: samples of every tick that this divides, from the next tick on; 0: none.
  void SampleEvery(std::uint64_t ticks) noexcept { sample_ticks_.store(ticks, std::memory_order_relaxed); }
  /// One thread: a sample, in order. Those for which there is no room are lost.
  bool TryPopSample(simulation::RunState& run_state) noexcept { return samples_.TryPop(run_state); }

  /// The thread that runs the ticks.
  const simulation::RunState& Now() const noexcept { return now_; }
  /// The same: as it would be published now, `message` or (kMaxMessages) all that nothing special befalls.
  simulation::Publication PublicationNow(std::size_t message) const noexcept;
  /// After which this run began: 0, or that of the snapshot. Any thread.
  std::uint64_t FirstTick() const noexcept { return first_tick_; }

  /// Entries of the script that could not be followed: too many faults at once. After the run.
  std::uint64_t ScriptRefused() const noexcept { return script_refused_; }

  /// From the arrival of a command's frame to the first tick that used it. Any thread.
  const rt::LatencyHistogram& ArrivalToTick() const noexcept { return arrival_to_tick_; }

 private:
  void Tick(bool silence_counts) noexcept;
  void TakeCommand() noexcept;
  void NoteCommand(std::int64_t arrival_ns) noexcept;
  void FollowGovernor(double p1_psi, std::int64_t arrival_ns) noexcept;
  bool FollowLocal(double p1_psi) noexcept;
  void ChangeSafety(const simulation::CommandMonitor::Decision& decision) noexcept;
  void TellSafetyChange(simulation::SafetyState from, std::uint64_t tick) noexcept;
  void TakeStatus() noexcept;
  void Publish(std::uint64_t tick) noexcept;
  void PublishSample() noexcept;
  void FollowScript() noexcept;
  simulation::Answer Serve(const simulation::Request& request) noexcept;
  void TakeFrames() noexcept;
  void TakeFrame(std::uint32_t id, bool extended) noexcept;
  void NoteStimulus(const simulation::Request& request) noexcept;
  void ObserveFaults() noexcept;
  void TellFaults() noexcept;
  void PutFaults() noexcept;
  std::span<const double> Truth(std::array<double, simulation::kMaxQuantities>& values) const noexcept;
  void PublishDue() noexcept;
  void TakeDueSnapshots() noexcept;
  bool TakeSnapshot() noexcept;
  void Account(const rt::LoopTiming& timing) noexcept;
  bool IsOverrun(const rt::LoopTiming& timing) noexcept;
  bool PublishFrozen() noexcept;
  bool GoesOn() const noexcept;

  simulation::Simulation simulation_;
  TaskOptions options_;
  simulation::RunState now_;
  simulation::CommandMonitor monitor_;
  std::uint64_t command_tick_ = 0;  ///< after which the newest command came
  std::uint64_t first_tick_ = 0;    ///< at which this run began
  std::uint64_t frozen_ticks_ = 0;  ///< for which simulated time stood still
  bool over_limit_ = false;         ///< more to catch up than allowed, at the last wake-up
  std::size_t next_snapshot_ = 0;
  std::uint64_t first_command_tick_ = 0;  ///< after which it came
  std::size_t next_script_ = 0;
  std::uint64_t script_refused_ = 0;
  rt::LatencyHistogram arrival_to_tick_;

  rt::Mailbox<simulation::Command> commands_;
  std::unique_ptr<fault::Sensors> sensors_ = std::make_unique<fault::Sensors>();
  std::atomic<std::uint64_t> clock_{0};
  std::atomic<std::uint64_t> snapshots_refused_{0};

  struct SeenFrame {
    std::uint32_t id = 0;
    bool extended = false;
  };
  rt::Ring<simulation::Publication, 1024> publications_;
  rt::Mailbox<simulation::RunState> newest_;
  std::atomic<std::uint64_t> sample_ticks_{0};
  rt::Ring<simulation::RunState, 1024> samples_;
  rt::Ring<simulation::SafetyChange, 256> safety_changes_;
  rt::Ring<Snapshot, 16> snapshots_;
  rt::Ring<simulation::Request, 64> requests_;
  rt::Ring<simulation::Answer, 64> answers_;
  rt::Ring<simulation::Request, 64> bus_requests_;
  rt::Ring<simulation::Answer, 64> bus_answers_;
  rt::Mailbox<fault::Schedule> faults_;
  rt::Mailbox<fault::Schedule> faults_of_receiver_;
  rt::Mailbox<fault::Schedule> faults_of_sender_;
  rt::Ring<SeenFrame, 64> frames_;
  rt::Ring<fault::Event, 1024> fault_events_;
};

}  // namespace servohil::emulator
