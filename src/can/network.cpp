#include "can/network.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <system_error>

#include "base/error.hpp"
#include "can/monotonic.hpp"
#include "can/realtime_clock.hpp"

namespace servohil::can {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kRetry{10};  // how often a bus that cannot be polled is asked
constexpr std::chrono::nanoseconds kEndless = std::chrono::hours(24);
constexpr short kInput = POLLIN;
constexpr int kMaxAtOnce = 64;  // a flood does not keep the receiver from what has passed

}  // namespace

Network::Network(const std::vector<std::string>& urls, const BusOptions& options) {
  buses_.reserve(urls.size());
  for (const std::string& url : urls) buses_.push_back(OpenBus(url, options));
  wake_fd_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (wake_fd_ < 0) {
    throw base::EnvironmentError("cannot make an event descriptor: " +
                                 std::generic_category().message(errno));
  }
  if (!options.model) return;
  for (const auto& bus : buses_) {
    if (!bus->IsVirtual())
      throw base::UsageError("can.emulate_bitrate is for virtual buses; " + bus->Name() +
                             " is a physical one");
  }
  model_.emplace(*options.model);
}

Network::~Network() {
  ::close(wake_fd_);
}

void Network::Wake() noexcept {
  const int saved_errno = errno;  // a signal handler leaves no trace
  woken_.store(true);
  ::eventfd_write(wake_fd_, 1);
  errno = saved_errno;
}

/// The receiver is to look again.
void Network::Poke() noexcept {
  ::eventfd_write(wake_fd_, 1);
}

void Network::Forward(const Frame& frame) noexcept {
  if (frame.error || !buses_[frame.bus]->IsVirtualSegment()) return;
  for (std::size_t i = 0; i < buses_.size(); ++i) {
    if (i != frame.bus && buses_[i]->IsVirtualSegment()) buses_[i]->Send(frame);
  }
}

std::optional<Frame> Network::ReceiveNow() noexcept {
  for (std::size_t i = 0; i < buses_.size(); ++i) {
    const std::size_t at = (next_ + i) % buses_.size();
    if (std::optional<Frame> frame = buses_[at]->Receive()) {
      next_ = (at + 1) % buses_.size();
      frame->bus = static_cast<std::uint8_t>(at);
      return frame;
    }
  }
  return std::nullopt;
}

std::optional<Frame> Network::ReceiveThroughModel() noexcept {
  for (int i = 0; i < kMaxAtOnce; ++i) {
    const std::optional<Frame> frame = ReceiveNow();
    if (!frame) break;
    if (frame->error) return frame;
    const std::lock_guard lock(model_mutex_);
    model_->Offer(*frame, BusModel::From::kOthers, MonotonicNs());
  }
  return TakePassed();
}

/// What has passed the bus: ours goes out, theirs is received.
std::optional<Frame> Network::TakePassed() noexcept {
  for (;;) {
    std::unique_lock lock(model_mutex_);
    std::optional<BusModel::Passed> passed = model_->Next(MonotonicNs());
    lock.unlock();
    if (!passed) return std::nullopt;
    if (passed->from == BusModel::From::kOthers) {
      passed->frame.receive_time_ns = RealTimeNs();
      return passed->frame;
    }
    SendToAll(passed->frame);
  }
}

std::chrono::nanoseconds Network::UntilModelMoves(std::chrono::nanoseconds most) noexcept {
  if (!model_) return most;
  const std::lock_guard lock(model_mutex_);
  const std::optional<std::int64_t> end_ns = model_->NextEnd();
  if (!end_ns) return most;
  return std::min(most, std::chrono::nanoseconds(std::max<std::int64_t>(*end_ns - MonotonicNs(), 0)));
}

void Network::WaitForInput(std::chrono::nanoseconds timeout) noexcept {
  std::vector<pollfd> descriptors{{wake_fd_, kInput, 0}};
  bool retry = nothing_but_errors_;
  for (const auto& bus : buses_) {
    // After a wait that brought errors alone, one round without the buses: an error that does not go away
    // must not keep this thread spinning.
    const int fd = nothing_but_errors_ ? -1 : bus->PollFd();
    retry = retry || fd < 0;
    descriptors.push_back({fd, kInput, 0});  // poll() ignores -1
  }
  if (retry) timeout = std::min<std::chrono::nanoseconds>(timeout, kRetry);
  timeout = UntilModelMoves(timeout);
  const timespec most{timeout.count() / kNsPerS, timeout.count() % kNsPerS};
  const int ready = ::ppoll(descriptors.data(), descriptors.size(), &most, nullptr);
  // Wake() stays, Poke() is once.
  eventfd_t pokes = 0;
  if (descriptors.front().revents != 0 && !woken_.load()) ::eventfd_read(wake_fd_, &pokes);
  nothing_but_errors_ =
      ready > 0 && std::none_of(descriptors.begin(), descriptors.end(), [](const pollfd& entry) {
        return (static_cast<unsigned>(entry.revents) & static_cast<unsigned>(POLLIN)) != 0;
      });
}

std::optional<Frame> Network::Receive(int timeout_ms) noexcept {
  const auto timeout = timeout_ms < 0 ? kEndless : std::chrono::milliseconds(timeout_ms);
  const Clock::time_point end = Clock::now() + timeout;
  while (!woken_.load()) {
    if (std::optional<Frame> frame = model_ ? ReceiveThroughModel() : ReceiveNow()) {
      nothing_but_errors_ = false;
      Forward(*frame);
      return frame;
    }
    const std::chrono::nanoseconds left = timeout_ms < 0 ? kEndless : end - Clock::now();
    if (left.count() <= 0) return std::nullopt;
    WaitForInput(left);
  }
  return std::nullopt;
}

SendResult Network::SendToAll(const Frame& frame) noexcept {
  SendResult worst = SendResult::kSent;
  for (const auto& bus : buses_) worst = std::max(worst, bus->Send(frame));
  return worst;
}

SendResult Network::Send(const Frame& frame) noexcept {
  if (!model_) return SendToAll(frame);
  bool accepted = false;
  {
    const std::lock_guard lock(model_mutex_);
    accepted = model_->Offer(frame, BusModel::From::kUs, MonotonicNs());
  }
  Poke();
  return accepted ? SendResult::kSent : SendResult::kQueueFull;
}

void Network::Flush() noexcept {
  if (!model_) return;
  while (const std::optional<std::int64_t> end_ns = model_->NextEnd()) {
    while (const std::optional<BusModel::Passed> passed = model_->Next(*end_ns)) {
      if (passed->from == BusModel::From::kUs) SendToAll(passed->frame);
    }
  }
}

std::uint64_t Network::Drain() noexcept {
  std::uint64_t unread = 0;
  for (const auto& bus : buses_) unread += bus->Drain();
  return unread;
}

std::optional<BusModelStatistics> Network::Modelled() const noexcept {
  if (!model_) return std::nullopt;
  const std::lock_guard lock(model_mutex_);
  return model_->Statistics();
}

BusStatistics Network::Statistics() const noexcept {
  BusStatistics sum;
  for (const auto& bus : buses_) {
    const BusStatistics one = bus->Statistics();
    sum.received += one.received;
    sum.sent += one.sent;
    sum.dropped_queue_full += one.dropped_queue_full;
    sum.dropped_disconnected += one.dropped_disconnected;
    sum.receive_overflows += one.receive_overflows;
    sum.malformed += one.malformed;
    sum.error_frames += one.error_frames;
  }
  return sum;
}

}  // namespace servohil::can
