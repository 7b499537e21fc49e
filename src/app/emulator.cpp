#include "servohil/app/emulator.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>

#include "servohil/error.hpp"
#include "servohil/rt/clock.hpp"

namespace servohil::app {
namespace {

constexpr std::int64_t kTickNs = 100'000;
/// The sender looks for work this long after the simulation's deadlines: enough for the ticks of one wake-up
/// (1000 ticks: 0.2 ms, tools/bench.sh), a small part of any published cycle.
constexpr std::int64_t kSenderDelayNs = 50'000;
constexpr int kReceiverPriorityBelow = 5;
constexpr int kSenderPriorityBelow = 10;

}  // namespace

Emulator::Emulator(const model::Derived& derived, const model::SteadyState& start, const Contract& contract,
                   can::Network& network, const EmulatorOptions& options)
    : contract_(contract),
      network_(network),
      options_(options),
      task_(std::make_unique<SimulationTask>(derived, start, contract, options)),
      loop_(options.loop.wake_ticks * kTickNs),
      finished_fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (finished_fd_ < 0) throw EnvironmentError("no event descriptor: too many open files");
}

Emulator::~Emulator() {
  Stop();
  close(finished_fd_);
}

rt::Shortcomings Emulator::Start() {
  if (options_.real_time != RealTime::kOff) shortcomings_ = rt::LockMemory();
  simulator_ = std::thread([this] { RunSimulation(); });
  receiver_ = std::thread([this] { RunReceiver(); });
  sender_ = std::thread([this] { RunSender(); });
  ready_.wait();
  if (options_.real_time == RealTime::kRequire && !shortcomings_.empty()) {
    stop_ = true;
    stop_sender_ = true;
    go_.count_down();
    Stop();
    throw EnvironmentError("--rt require: " + shortcomings_.front());
  }
  first_deadline_ns_ = rt::MonotonicNs() + options_.loop.wake_ticks * kTickNs;
  go_.count_down();
  return shortcomings_;
}

void Emulator::Stop() noexcept {
  if (!sender_.joinable()) return;
  stop_ = true;
  simulator_.join();
  network_.Wake();
  receiver_.join();
  stop_sender_ = true;
  sender_.join();
  SendDue(true);
  SendStopped();
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
  BeReady("sim", options_.loop.priority, options_.loop.cpu);
  const long faults_before = rt::ThreadPageFaults();
  loop_.Run(
      stop_, [this](const rt::LoopTiming& timing) noexcept { return task_->Wake(timing); },
      first_deadline_ns_);
  loop_page_faults_ = rt::ThreadPageFaults() - faults_before;
  eventfd_write(finished_fd_, 1);
}

void Emulator::RunReceiver() {
  BeReady("can_rx", options_.loop.priority - kReceiverPriorityBelow, -1);
  constexpr int kForEver = -1;
  while (!stop_.load(std::memory_order_relaxed)) {
    const std::optional<can::Frame> frame = network_.Receive(kForEver);
    if (!frame) continue;
    CommandRejection rejection{};
    if (const std::optional<Command> command = contract_.DecodeCommand(*frame, rejection)) {
      task_->PutCommand(*command);
      ++traffic_.commands;
      continue;
    }
    switch (rejection) {
      case CommandRejection::kUnknownId:
        ++traffic_.foreign;
        break;
      case CommandRejection::kMalformed:
        ++traffic_.malformed;
        break;
      case CommandRejection::kOutOfRange:
        ++traffic_.out_of_range;
        break;
    }
  }
}

void Emulator::RunSender() {
  BeReady("can_tx", options_.loop.priority - kSenderPriorityBelow, -1);
  rt::PeriodicLoop loop(options_.loop.wake_ticks * kTickNs);
  loop.Run(
      stop_sender_,
      [this](const rt::LoopTiming&) noexcept {
        SendDue(false);
        return true;
      },
      first_deadline_ns_ + kSenderDelayNs);
}

void Emulator::SendDue(bool at_once) noexcept {
  // Of several states that wait, only the newest of each message is sent, and no two closer than half its
  // cycle: after a delay the bus gets the present, not a burst of the past.
  Telemetry telemetry;
  while (task_->TryPopTelemetry(telemetry)) {
    for (std::size_t i = 0; i < kPublishedCount; ++i) {
      if (!telemetry.due[i]) continue;
      if (waiting_[i].due) ++traffic_.superseded;
      waiting_[i].due = true;
      waiting_[i].telemetry = telemetry;
    }
  }
  const std::int64_t now_ns = rt::MonotonicNs();
  for (std::size_t i = 0; i < kPublishedCount; ++i) {
    const auto which = static_cast<Published>(i);
    if (!waiting_[i].due || (now_ns < waiting_[i].not_before_ns && !at_once)) continue;
    waiting_[i].due = false;
    waiting_[i].not_before_ns = now_ns + static_cast<std::int64_t>(contract_.CycleTicks(which)) * kTickNs / 2;
    SendMessage(which, waiting_[i].telemetry);
  }
}

void Emulator::SendStopped() noexcept {
  if (contract_.CycleTicks(Published::kStatus) == 0) return;
  Telemetry last = task_->Final();
  last.status.mode = Mode::kStopped;
  SendMessage(Published::kStatus, last);
}

void Emulator::SendMessage(Published which, const Telemetry& telemetry) noexcept {
  const can::Frame frame = contract_.Encode(which, telemetry, task_->OutputsAt(telemetry.sample));
  const bool sent = network_.Send(frame) == can::SendResult::kSent;
  ++(sent ? traffic_.published : traffic_.not_sent);
}

}  // namespace servohil::app
