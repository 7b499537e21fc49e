#pragma once
/// The running emulator: simulation, receiver and sender, each a thread, and the channels between them.
///
///   network → [can_rx] decode ─ Command ▶ mailbox ▶ [sim] tick ─ Telemetry ▶ ring ▶ [can_tx] encode →
///   network
///                                                      └─ Telemetry ▶ mailbox ▶ whoever watches

#include <array>
#include <atomic>
#include <cstdint>
#include <latch>
#include <memory>
#include <mutex>
#include <thread>

#include "servohil/app/contract.hpp"
#include "servohil/app/simulation.hpp"
#include "servohil/app/telemetry.hpp"
#include "servohil/can/network.hpp"
#include "servohil/rt/mailbox.hpp"
#include "servohil/rt/periodic_loop.hpp"
#include "servohil/rt/process.hpp"
#include "servohil/rt/ring.hpp"

namespace servohil::app {

/// How much real time is asked of the machine.
enum class RealTime : std::uint8_t { kRequire, kPrefer, kOff };

struct EmulatorOptions {
  LoopSettings loop;
  RealTime real_time = RealTime::kPrefer;
  std::uint64_t duration_ticks = 0;  ///< 0: until Stop()
};

/// Frames and why some did not count; totals since the start.
struct TrafficCounters {
  std::atomic<std::uint64_t> commands{0};
  std::atomic<std::uint64_t> foreign{0};
  std::atomic<std::uint64_t> malformed{0};
  std::atomic<std::uint64_t> out_of_range{0};
  std::atomic<std::uint64_t> published{0};
  std::atomic<std::uint64_t> not_sent{0};    ///< refused by a full queue or a bus that is down
  std::atomic<std::uint64_t> superseded{0};  ///< not sent because a newer state was already there
};

/// The simulation thread's work, without the thread: one call a wake-up. Owned by the emulator; the tests run
/// it in their own loops.
class SimulationTask {
 public:
  SimulationTask(const model::Derived& derived, const model::SteadyState& start, const Contract& contract,
                 const EmulatorOptions& options) noexcept;

  /// Any one thread: newest valid command. Real-time safe.
  void PutCommand(const Command& command) noexcept { commands_.Put(command); }

  /// One wake-up: `wake_ticks` ticks, each with the newest command. @return false after the last tick.
  /// Real-time safe.
  bool Wake(const rt::LoopTiming& timing) noexcept;

  /// The sender: what is due, oldest first. Real-time safe.
  bool TryPopTelemetry(Telemetry& telemetry) noexcept { return telemetry_.TryPop(telemetry); }
  std::uint64_t TelemetryDropped() const noexcept { return telemetry_.Dropped(); }
  /// Whoever watches (one thread): the newest state.
  bool TakeNewest(Telemetry& telemetry) noexcept { return newest_.Take(telemetry); }

  /// After the last Wake().
  Telemetry Final() const noexcept { return now_; }
  model::Outputs OutputsAt(const Sample& sample) const noexcept { return simulation_.OutputsAt(sample); }

 private:
  void Tick() noexcept;
  void Publish() noexcept;

  Simulation simulation_;
  std::array<std::uint64_t, kPublishedCount> cycle_ticks_{};
  int wake_ticks_;
  std::uint64_t duration_ticks_;
  Telemetry now_;
  Command command_;
  std::uint64_t command_tick_ = 0;

  rt::Mailbox<Command> commands_;
  rt::Ring<Telemetry, 1024> telemetry_;
  rt::Mailbox<Telemetry> newest_;
};

class Emulator {
 public:
  /// @param network, contract  must outlive the emulator
  Emulator(const model::Derived& derived, const model::SteadyState& start, const Contract& contract,
           can::Network& network, const EmulatorOptions& options);
  ~Emulator();
  Emulator(const Emulator&) = delete;
  Emulator& operator=(const Emulator&) = delete;

  /// Starts the threads. Whatever real-time property could not be had is returned.
  /// @throws EnvironmentError when it is required
  rt::Shortcomings Start();
  /// Readable once the duration is over.
  int FinishedFd() const noexcept { return finished_fd_; }
  /// Ends the threads; the last status goes out with mode STOPPED. Idempotent.
  void Stop() noexcept;

  bool TakeNewest(Telemetry& telemetry) noexcept { return task_->TakeNewest(telemetry); }
  const TrafficCounters& Traffic() const noexcept { return traffic_; }

  // After Stop():
  const rt::LoopTiming& Timing() const noexcept { return loop_.Timing(); }
  Telemetry Final() const noexcept { return task_->Final(); }
  std::uint64_t TelemetryDropped() const noexcept { return task_->TelemetryDropped(); }
  /// Page faults of the simulation thread inside its loop.
  long LoopPageFaults() const noexcept { return loop_page_faults_; }

 private:
  void RunSimulation();
  void RunReceiver();
  void RunSender();
  /// Sets up the calling thread, then waits for the start.
  void BeReady(const char* name, int priority, int cpu);
  /// @param at_once  whatever was sent just before, as at the end
  void SendDue(bool at_once) noexcept;
  void SendStopped() noexcept;
  void SendMessage(Published which, const Telemetry& telemetry) noexcept;

  const Contract& contract_;
  can::Network& network_;
  EmulatorOptions options_;
  std::unique_ptr<SimulationTask> task_;
  rt::PeriodicLoop loop_;
  std::int64_t first_deadline_ns_ = 0;
  long loop_page_faults_ = 0;
  /// The sender's: newest state of each message that is due, and when it may go.
  struct Waiting {
    bool due = false;
    std::int64_t not_before_ns = 0;
    Telemetry telemetry;
  };
  std::array<Waiting, kPublishedCount> waiting_;
  TrafficCounters traffic_;
  int finished_fd_ = -1;

  std::mutex shortcomings_mutex_;
  rt::Shortcomings shortcomings_;
  std::latch ready_{3};
  std::latch go_{1};
  std::atomic<bool> stop_{false};         ///< simulation and receiver
  std::atomic<bool> stop_sender_{false};  ///< later: it still sends what the simulation has left
  std::thread simulator_;
  std::thread receiver_;
  std::thread sender_;
};

}  // namespace servohil::app
