#include "servohil/app/emulator.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>

#include "servohil/app/ticks.hpp"
#include "servohil/error.hpp"
#include "servohil/rt/clock.hpp"

namespace servohil::app {
namespace {

constexpr int kTicksPerMs = 10;
constexpr double kNsPerMs = 1e6;
/// The sender looks for work this long after the simulation's deadlines: enough for the ticks of one wake-up
/// (1000 ticks: 0.2 ms, tools/bench.sh), a small part of any published cycle.
constexpr std::int64_t kSenderDelayNs = 50'000;
constexpr int kReceiverPriorityBelow = 5;
constexpr int kSenderPriorityBelow = 10;
constexpr int kForEver = -1;
constexpr int kLookForDelayedMs = 1;
constexpr int kLookForRequestsMs = 2;  ///< in lockstep, where no tick does

/// In lockstep each answer has every message, whatever its cycle.
TaskOptions TaskOptionsOf(const EmulatorOptions& options, const Contract& contract) {
  TaskOptions task = options.task;
  task.safety = LawOf(options.safety);
  if (options.clock == Clock::kReal) {
    task.cycle_ticks = contract.Cycles();
    task.max_age_ns = static_cast<std::int64_t>(options.safety.max_age_ms * kNsPerMs);
    task.stall = [](double ms) noexcept {
      rt::SleepUntil(rt::MonotonicNs() + static_cast<std::int64_t>(ms * kNsPerMs));
    };
  }
  task.tell_lateness = contract.MessagesCarrying("recent_lateness_ms");
  return task;
}

}  // namespace

Emulator::Emulator(const model::Parameters& parameters, const model::SteadyState& start,
                   const Contract& contract, can::Network& network, const EmulatorOptions& options)
    : network_(network),
      options_(options),
      task_(std::make_unique<SimulationTask>(parameters, start, TaskOptionsOf(options, contract))),
      receiver_(std::make_unique<Receiver>(
          contract, CommandGuard(options.safety, options.command_cycle_ms), *task_, options.task.recorder,
          options.clock == Clock::kReal ? FrameClock::kReal : FrameClock::kSimulated)),
      sender_(std::make_unique<Sender>(contract, *task_, network, options.task.recorder)),
      loop_(options.task.loop.wake_ticks * kTickNs,
            static_cast<std::uint64_t>(options.task.loop.grace_ms * kTicksPerMs /
                                       options.task.loop.wake_ticks)),
      finished_fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (finished_fd_ < 0) throw EnvironmentError("no event descriptor: too many open files");
}

Emulator::~Emulator() {
  Stop();
  close(finished_fd_);
}

rt::Shortcomings Emulator::Start() {
  if (options_.clock == Clock::kReal) {
    StartRealTime();
  } else {
    simulation_thread_ = std::thread([this] { RunLockstep(); });
  }
  return shortcomings_;
}

void Emulator::StartRealTime() {
  if (options_.real_time != RealTime::kOff) {
    shortcomings_ = rt::LockMemory();
    awake_.emplace();  // without it wake-ups are slower: `servohil check` tells, the loop's account shows
  }
  simulation_thread_ = std::thread([this] { RunSimulation(); });
  receiver_thread_ = std::thread([this] { RunReceiver(); });
  sender_thread_ = std::thread([this] { RunSender(); });
  ready_.wait();
  if (options_.real_time == RealTime::kRequire && !shortcomings_.empty()) {
    stop_ = true;
    stop_sender_ = true;
    go_.count_down();
    Stop();
    throw EnvironmentError("--rt require: " + shortcomings_.front());
  }
  first_deadline_ns_ = rt::MonotonicNs() + options_.task.loop.wake_ticks * kTickNs;
  go_.count_down();
}

void Emulator::Stop() noexcept {
  if (!simulation_thread_.joinable()) return;
  stop_ = true;
  if (options_.clock == Clock::kReal) {
    simulation_thread_.join();
    network_.Wake();
    receiver_thread_.join();
    stop_sender_ = true;
    sender_thread_.join();
    sender_->SendRest();
  } else {
    network_.Wake();
    simulation_thread_.join();
  }
  sender_->SendStopped();
  awake_.reset();
}

void Emulator::Finish() noexcept {
  eventfd_write(finished_fd_, 1);
}

void Emulator::BeReady(const char* name, int priority, int cpu) {
  rt::NameThread(name);
  if (options_.real_time != RealTime::kOff) {
    const rt::Shortcomings missing = rt::MakeThreadRealTime(std::max(priority, 1), cpu);
    const std::lock_guard lock(shortcomings_mutex_);
    for (const std::string& one : missing) {
      // One line is enough for what all threads lack.
      if (shortcomings_.size() < 2) shortcomings_.push_back(one);
    }
  }
  rt::PrefaultStack();
  ready_.count_down();
  go_.wait();
}

void Emulator::RunSimulation() {
  BeReady("sim", options_.task.loop.priority, options_.task.loop.cpu);
  const long faults_before = rt::ThreadPageFaults();
  loop_.Run(
      stop_,
      [this](const rt::LoopTiming& timing) noexcept {
        turns_.store(timing.wakes, std::memory_order_relaxed);
        return task_->Wake(timing);
      },
      first_deadline_ns_);
  loop_page_faults_ = rt::ThreadPageFaults() - faults_before;
  Finish();
}

void Emulator::RunReceiver() {
  BeReady("can_rx", options_.task.loop.priority - kReceiverPriorityBelow, -1);
  while (!stop_.load(std::memory_order_relaxed)) {
    const int wait_ms = receiver_->HasDelayed() ? kLookForDelayedMs : kForEver;
    if (const std::optional<can::Frame> frame = network_.Receive(wait_ms)) receiver_->Take(*frame);
    receiver_->TakeDelayed();
  }
}

void Emulator::RunSender() {
  BeReady("can_tx", options_.task.loop.priority - kSenderPriorityBelow, -1);
  rt::PeriodicLoop loop(options_.task.loop.wake_ticks * kTickNs);
  loop.Run(
      stop_sender_,
      [this](const rt::LoopTiming&) noexcept {
        sender_->SendDue();
        return true;
      },
      first_deadline_ns_ + kSenderDelayNs);
}

void Emulator::RunLockstep() {
  rt::NameThread("sim");
  bool goes_on = true;
  while (goes_on && !stop_.load(std::memory_order_relaxed)) {
    const std::optional<can::Frame> frame = network_.Receive(kLookForRequestsMs);
    turns_.fetch_add(1, std::memory_order_relaxed);
    task_->ServeRequests();
    if (!frame) continue;
    const bool by_command = options_.lockstep.sync_id < 0;
    const std::uint64_t valid_before = receiver_->ValidCommands();
    const bool is_command = receiver_->Take(*frame);
    if (by_command ? !is_command : !IsSync(*frame)) continue;
    receiver_->TakeDelayed();
    // A valid command is never late: time waits for it. A cycle without one is silence.
    const bool commanded = receiver_->ValidCommands() != valid_before;
    goes_on = task_->Run(options_.lockstep.ticks, !by_command || !commanded);
    sender_->SendAll(stop_);
  }
  Finish();
}

bool Emulator::IsSync(const can::Frame& frame) const noexcept {
  return !frame.extended && !frame.remote &&
         frame.id == static_cast<std::uint32_t>(options_.lockstep.sync_id);
}

}  // namespace servohil::app
