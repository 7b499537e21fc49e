#pragma once
/// The running emulator: its threads and the channels between them.
///
/// In real time, three threads:
///   network → [can_rx] decode ─ Command ▶ mailbox ▶ [sim] tick ─ RunState ▶ ring ▶ [can_tx] encode →
///   network
///                                                     └─ RunState ▶ mailbox ▶ whoever watches
/// In lockstep, one: network → decode → n ticks → encode → network, each frame for itself.

#include <atomic>
#include <cstdint>
#include <latch>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "can/network.hpp"
#include "emulator/fault_port.hpp"
#include "emulator/lockstep_bus.hpp"
#include "emulator/receiver.hpp"
#include "emulator/sender.hpp"
#include "emulator/simulation_task.hpp"
#include "rt/cpu_latency.hpp"
#include "rt/periodic_loop.hpp"
#include "rt/process.hpp"
#include "signal_map/signal_map.hpp"

namespace servohil::emulator {

/// How much real time is asked of the machine.
enum class RealTime : std::uint8_t { kRequire, kPrefer, kOff };

/// Who says when time passes.
enum class Clock : std::uint8_t {
  kReal,      ///< the machine's clock
  kLockstep,  ///< the governor's frames
  kFast,      ///< nobody: as fast as it goes
};

struct EmulatorOptions {
  TaskOptions task;
  Clock clock = Clock::kReal;  ///< kReal or kLockstep
  configuration::LockstepSettings lockstep;
  configuration::SafetySettings safety;               ///< Resolved()
  int command_cycle_ms = 10;                          ///< of the governor
  int max_counter_jump = 1;                           ///< of protected commands
  std::optional<can::BusModelSettings> lockstep_bus;  ///< in lockstep, frames take their time and turn
  RealTime real_time = RealTime::kPrefer;             ///< of no importance in lockstep
  FaultPort* fault_port = nullptr;  ///< faults over CAN; must outlive the emulator; none: not allowed
};

class Emulator {
 public:
  /// @param network, signal_map  must outlive the emulator
  Emulator(const model::Parameters& parameters, const model::SteadyState& start,
           const signal_map::SignalMap& signal_map, can::Network& network, const EmulatorOptions& options);
  ~Emulator();
  Emulator(const Emulator&) = delete;
  Emulator& operator=(const Emulator&) = delete;

  /// Before Start(): goes on from there.
  void Restore(const Snapshot& snapshot) noexcept { task_->Restore(snapshot); }

  /// Starts the threads. Whatever real-time property could not be had is returned.
  /// @throws EnvironmentError when it is required
  rt::Shortcomings Start();
  /// Readable once the run has ended by itself.
  int FinishedFd() const noexcept { return finished_fd_; }
  /// Ends the threads; the last status goes out with mode STOPPED. Idempotent.
  void Stop() noexcept;

  // Any time, one thread:
  bool TakeNewest(simulation::RunState& run_state) noexcept { return task_->TakeNewest(run_state); }
  bool PutRequest(const simulation::Request& request) noexcept { return task_->PutRequest(request); }
  bool TryPopAnswer(simulation::Answer& answer) noexcept { return task_->TryPopAnswer(answer); }
  bool TakeFaults(fault::Schedule& faults) noexcept { return task_->TakeFaults(faults); }
  bool TryPopSafetyChange(simulation::SafetyChange& change) noexcept {
    return task_->TryPopSafetyChange(change);
  }
  bool TryPopFaultEvent(fault::Event& event) noexcept { return task_->TryPopFaultEvent(event); }
  std::uint64_t SnapshotsRefused() const noexcept { return task_->SnapshotsRefused(); }
  void SampleEvery(std::uint64_t ticks) noexcept { task_->SampleEvery(ticks); }
  bool TryPopSample(simulation::RunState& run_state) noexcept { return task_->TryPopSample(run_state); }
  bool TryPopSnapshot(Snapshot& snapshot) noexcept { return task_->TryPopSnapshot(snapshot); }
  const signal_map::SignalMap& Frames() const noexcept { return signal_map_; }
  const ReceiveCounters& Received() const noexcept { return receiver_->Counters(); }
  bool TakeBusErrors(std::size_t bus, can::ErrorTotals& errors) noexcept {
    return receiver_->TakeErrors(bus, errors);
  }
  std::uint64_t Conflicts(std::size_t bus) const noexcept { return receiver_->Conflicts(bus); }
  /// Of the bus model, where there is one; in lockstep after Stop().
  std::optional<can::BusModelStatistics> ModelledBus() const noexcept;
  /// For the messages that tell it.
  void PutBusCondition(const can::BusCondition& condition) noexcept { sender_->PutBusCondition(condition); }
  const SendCounters& Sent() const noexcept { return sender_->Counters(); }
  const rt::LatencyHistogram& ArrivalToTick() const noexcept { return task_->ArrivalToTick(); }
  const rt::LatencyHistogram& ArrivalToFrame() const noexcept { return sender_->ArrivalToFrame(); }
  /// Rises while the simulation's loop goes on, whether or not simulated time passes. Any thread.
  std::uint64_t LoopIterations() const noexcept { return loop_iterations_.load(std::memory_order_relaxed); }
  /// Its histograms; the rest after Stop().
  const rt::LoopTiming& Timing() const noexcept { return loop_.Timing(); }
  /// After which the run began: 0, or that of the snapshot.
  std::uint64_t FirstTick() const noexcept { return task_->FirstTick(); }

  // After Stop():
  const simulation::RunState& Final() const noexcept { return task_->Now(); }
  std::uint64_t PublicationsDropped() const noexcept { return task_->PublicationsDropped(); }
  std::uint64_t ScriptRefused() const noexcept { return task_->ScriptRefused(); }
  /// Page faults of the simulation thread inside its loop.
  long LoopPageFaults() const noexcept { return loop_page_faults_; }

 private:
  void StartRealTime();
  void RunSimulation();
  void RunReceiver();
  void RunSender();
  void RunLockstep();
  std::optional<can::Frame> NextInLockstep() noexcept;
  /// What a frame brings about in lockstep. @return false at the end of the run
  bool Follow(const can::Frame& frame) noexcept;
  bool FollowOnModelledBus(const can::Frame& frame) noexcept;
  /// Receiver: what a FAULT_Request frame asks.
  void TakeFaultRequest(const can::Frame& frame) noexcept;
  /// Sender: FAULT_Response frames.
  void SendFaultResponses() noexcept;
  void SendFaultResponse(const can::Frame& frame) noexcept;
  bool IsSilence(std::uint64_t valid_before) const noexcept;
  bool LetsTimePass(const can::Frame& frame, bool is_command) const noexcept;
  /// Sets up the calling thread, then waits for the start.
  void BeReady(const char* name, int priority, int cpu);
  void Finish() noexcept;

  const signal_map::SignalMap& signal_map_;
  can::Network& network_;
  EmulatorOptions options_;
  std::unique_ptr<SimulationTask> task_;
  std::unique_ptr<Receiver> receiver_;
  std::unique_ptr<Sender> sender_;
  std::optional<LockstepBus> lockstep_bus_;
  rt::PeriodicLoop loop_;
  std::vector<std::size_t> as_listed_;  ///< the order of messages without a modelled bus
  std::int64_t first_deadline_ns_ = 0;
  long loop_page_faults_ = 0;
  int finished_fd_ = -1;

  std::optional<rt::CpuLatencyHold> awake_;  ///< keeps the CPUs out of deep idle states
  std::mutex shortcomings_mutex_;
  rt::Shortcomings shortcomings_;
  std::latch ready_{3};
  std::latch go_{1};
  std::atomic<std::uint64_t> loop_iterations_{0};  ///< of the simulation's loop
  std::atomic<bool> stop_{false};                  ///< simulation and receiver
  std::atomic<bool> stop_sender_{false};           ///< later: it still sends what the simulation has left
  std::thread simulation_thread_;
  std::thread receiver_thread_;
  std::thread sender_thread_;
};

}  // namespace servohil::emulator
