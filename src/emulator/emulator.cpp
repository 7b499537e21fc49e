#include "emulator/emulator.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "base/clock.hpp"
#include "base/error.hpp"
#include "emulator/sender_schedule.hpp"
#include "model/ticks.hpp"

namespace servohil::emulator {
namespace {

/// The sender looks for work this long after the simulation's deadlines: enough for the ticks of one wake-up
/// (1000 ticks: 0.2 ms, tools/bench.sh), a small part of any published cycle.
constexpr std::int64_t kSenderDelayNs = 50'000;
constexpr std::int64_t kResponsesEveryNs = 5'000'000;     ///< to FAULT_Request: half of what they may take
constexpr std::int64_t kSenderLooksEveryNs = 20'000'000;  ///< at least: for what is due by no cycle
constexpr std::int64_t kOneWake = 1;
constexpr int kReceiverPriorityBelow = 5;
constexpr int kSenderPriorityBelow = 10;
constexpr int kForEver = -1;
constexpr int kLookForDelayedMs = 1;
constexpr int kLookForRequestsMs = 2;  ///< in lockstep, where no tick does

/// In lockstep each answer has every message, whatever its cycle.
TaskOptions TaskOptionsOf(const EmulatorOptions& options, const signal_map::SignalMap& signal_map) {
  TaskOptions task = options.task;
  task.safety = simulation::LawOf(options.safety);
  if (options.clock == Clock::kReal) {
    task.cycle_ticks = signal_map.Cycles();
    task.max_age_ns = options.safety.max_age_ms * base::kNsPerMs;
    task.stall = [](double ms) noexcept {
      base::SleepUntil(base::MonotonicNs() + static_cast<std::int64_t>(ms * double{base::kNsPerMs}));
    };
  }
  task.tell_lateness = signal_map.MessagesCarrying("recent_lateness_ms");
  return task;
}

}  // namespace

Emulator::Emulator(const model::Parameters& parameters, const model::SteadyState& start,
                   const signal_map::SignalMap& signal_map, can::Network& network,
                   const EmulatorOptions& options)
    : signal_map_(signal_map),
      network_(network),
      options_(options),
      task_(std::make_unique<SimulationTask>(parameters, start, TaskOptionsOf(options, signal_map))),
      receiver_(std::make_unique<Receiver>(
          signal_map,
          ValidatorOf(signal_map, options.safety, options.command_cycle_ms, options.max_counter_jump), *task_,
          options.task.recorder, network.Buses().size(),
          options.clock == Clock::kReal ? FrameClock::kReal : FrameClock::kSimulated)),
      sender_(std::make_unique<Sender>(signal_map, *task_, network, options.task.recorder)),
      loop_(options.task.loop.wake_ticks * model::kTickNs,
            static_cast<std::uint64_t>(options.task.loop.grace_ms * model::kTicksPerMs /
                                       options.task.loop.wake_ticks)),
      as_listed_(signal_map.MessageCount()),
      finished_fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (finished_fd_ < 0) throw base::EnvironmentError("no event descriptor: too many open files");
  std::iota(as_listed_.begin(), as_listed_.end(), std::size_t{0});
}

Emulator::~Emulator() {
  Stop();
  close(finished_fd_);
}

rt::Shortcomings Emulator::Start() {
  if (options_.clock == Clock::kReal) {
    StartRealTime();
  } else {
    if (options_.lockstep_bus) lockstep_bus_.emplace(signal_map_, *options_.lockstep_bus);
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
    throw base::EnvironmentError("--rt require: " + shortcomings_.front());
  }
  first_deadline_ns_ = base::MonotonicNs() + options_.task.loop.wake_ticks * model::kTickNs;
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
    SendFaultResponses();
  } else {
    network_.Wake();
    simulation_thread_.join();
  }
  sender_->SendStopped();
  network_.Flush();
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
        loop_iterations_.store(timing.wakes, std::memory_order_relaxed);
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
    if (const std::optional<can::Frame> frame = network_.Receive(wait_ms)) {
      receiver_->Take(*frame);
      TakeFaultRequest(*frame);
    }
    receiver_->TakeDelayed();
  }
}

void Emulator::RunSender() {
  BeReady("can_tx", options_.task.loop.priority - kSenderPriorityBelow, -1);
  const std::int64_t period_ns = options_.task.loop.wake_ticks * model::kTickNs;
  const std::int64_t first_ns = first_deadline_ns_ + kSenderDelayNs;
  const std::int64_t looks_every_ns =
      options_.fault_port != nullptr ? kResponsesEveryNs : kSenderLooksEveryNs;
  const SenderSchedule schedule(signal_map_.Cycles(),
                                static_cast<std::uint64_t>(options_.task.loop.wake_ticks), task_->FirstTick(),
                                static_cast<std::uint64_t>(std::max(looks_every_ns / period_ns, kOneWake)));
  std::uint64_t wake = 1;
  while (!stop_sender_.load(std::memory_order_relaxed)) {
    base::SleepUntil(first_ns + static_cast<std::int64_t>(wake - 1) * period_ns);
    sender_->SendDue();
    SendFaultResponses();
    // Where the simulation is behind, or a message must wait for its time, the next wake-up brings more.
    wake = sender_->IsDoneUpTo(schedule.NewestDue(wake)) ? schedule.Next(wake) : wake + 1;
    const std::int64_t passed = (base::MonotonicNs() - first_ns) / period_ns + 1;
    wake = std::max(wake, static_cast<std::uint64_t>(std::max(passed, kOneWake)));
  }
}

void Emulator::RunLockstep() {
  rt::NameThread("sim");
  bool goes_on = true;
  while (goes_on && !stop_.load(std::memory_order_relaxed)) {
    if (const std::optional<can::Frame> frame = NextInLockstep())
      goes_on = lockstep_bus_ ? FollowOnModelledBus(*frame) : Follow(*frame);
  }
  Finish();
}

/// What it asks of faults is answered here, at once: no time need pass for it. Empty: none came for a while.
std::optional<can::Frame> Emulator::NextInLockstep() noexcept {
  const std::optional<can::Frame> frame = network_.Receive(kLookForRequestsMs);
  loop_iterations_.fetch_add(1, std::memory_order_relaxed);
  task_->ServeRequests();
  if (!frame || frame->error) return frame;
  TakeFaultRequest(*frame);
  task_->ServeRequests();
  SendFaultResponses();
  return frame;
}

bool Emulator::Follow(const can::Frame& frame) noexcept {
  const std::uint64_t valid_before = receiver_->ValidCommands();
  const bool is_command = receiver_->Take(frame);
  if (!LetsTimePass(frame, is_command)) return true;
  receiver_->TakeDelayed();
  const bool goes_on = task_->Run(options_.lockstep.ticks, IsSilence(valid_before));
  sender_->SendAll(stop_, as_listed_);
  return goes_on;
}

/// What is received waits for the modelled bus and acts within the tick in which it has passed. A frame with
/// the command's identifier lets time pass even before it can be told whether it is a valid one.
bool Emulator::FollowOnModelledBus(const can::Frame& frame) noexcept {
  if (frame.error) {
    receiver_->Take(frame);
    return true;
  }
  std::uint64_t tick = task_->Now().sample.tick;
  lockstep_bus_->Offer(frame, tick);
  const bool is_command =
      !frame.remote && signal_map_.IncomingMessages().front().pattern.Matches(frame.id, frame.extended);
  if (!LetsTimePass(frame, is_command)) return true;
  const std::uint64_t end = tick + static_cast<std::uint64_t>(options_.lockstep.ticks);
  const std::uint64_t valid_before = receiver_->ValidCommands();
  const bool by_sync = options_.lockstep.sync_id >= 0;
  bool goes_on = true;
  for (auto passed = lockstep_bus_->Next(end); passed; passed = lockstep_bus_->Next(end)) {
    goes_on = goes_on && task_->Run(static_cast<int>(passed->tick - tick), by_sync);
    tick = passed->tick;
    receiver_->Take(passed->frame);
  }
  receiver_->TakeDelayed();
  goes_on = goes_on && task_->Run(static_cast<int>(end - tick), IsSilence(valid_before));
  sender_->SendAll(stop_, lockstep_bus_->Order());
  lockstep_bus_->OfferAnswer(end);
  return goes_on;
}

std::optional<can::BusModelStatistics> Emulator::ModelledBus() const noexcept {
  return lockstep_bus_ ? lockstep_bus_->Statistics() : network_.Modelled();
}

void Emulator::TakeFaultRequest(const can::Frame& frame) noexcept {
  if (options_.fault_port == nullptr) return;
  const std::optional<simulation::Request> request = options_.fault_port->Take(frame);
  if (request && !task_->PutBusRequest(*request)) options_.fault_port->TellBusy(*request);
}

void Emulator::SendFaultResponses() noexcept {
  if (options_.fault_port == nullptr) return;
  can::Frame frame;
  while (options_.fault_port->TryPopResponse(frame)) SendFaultResponse(frame);
  simulation::Answer answer;
  while (task_->TryPopBusAnswer(answer)) SendFaultResponse(options_.fault_port->ResponseTo(answer));
}

void Emulator::SendFaultResponse(const can::Frame& frame) noexcept {
  const bool sent = network_.Send(frame) == can::SendResult::kSent;
  recording::Recorder* recorder = options_.task.recorder;
  if (sent && recorder != nullptr) recorder->RecordSent(task_->Clock(), simulation::kMaxMessages, frame);
}

/// A valid command is never late: time waits for it. A cycle without one is silence.
bool Emulator::IsSilence(std::uint64_t valid_before) const noexcept {
  return options_.lockstep.sync_id >= 0 || receiver_->ValidCommands() == valid_before;
}

bool Emulator::LetsTimePass(const can::Frame& frame, bool is_command) const noexcept {
  if (options_.lockstep.sync_id < 0) return is_command;
  return !frame.extended && !frame.remote && !frame.error &&
         frame.id == static_cast<std::uint32_t>(options_.lockstep.sync_id);
}

}  // namespace servohil::emulator
