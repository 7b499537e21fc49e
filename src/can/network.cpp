#include "servohil/can/network.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <system_error>

#include "servohil/error.hpp"

namespace servohil::can {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kRetryMs = 10;  // how often a bus that cannot be polled is asked
constexpr short kInput = POLLIN;

/// Milliseconds to wait, rounded up; -1 without end.
int Remaining(Clock::time_point end, bool endless) noexcept {
  if (endless) return -1;
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now()).count();
  return static_cast<int>(std::max<std::int64_t>(left, 0));
}

}  // namespace

Network::Network(const std::vector<std::string>& urls, const BusOptions& options) {
  buses_.reserve(urls.size());
  for (const std::string& url : urls) buses_.push_back(OpenBus(url, options));
  wake_fd_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (wake_fd_ < 0) {
    throw EnvironmentError("cannot make an event descriptor: " + std::generic_category().message(errno));
  }
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

void Network::Forward(const Frame& frame, std::size_t from) noexcept {
  if (!buses_[from]->IsVirtualSegment()) return;
  for (std::size_t i = 0; i < buses_.size(); ++i) {
    if (i != from && buses_[i]->IsVirtualSegment()) buses_[i]->Send(frame);
  }
}

std::optional<Frame> Network::ReceiveNow() noexcept {
  for (std::size_t i = 0; i < buses_.size(); ++i) {
    const std::size_t at = (next_ + i) % buses_.size();
    if (std::optional<Frame> frame = buses_[at]->Receive()) {
      next_ = (at + 1) % buses_.size();
      Forward(*frame, at);
      frame->bus = static_cast<std::uint8_t>(at);
      return frame;
    }
  }
  return std::nullopt;
}

void Network::WaitForInput(int timeout_ms) noexcept {
  std::vector<pollfd> descriptors{{wake_fd_, kInput, 0}};
  bool retry = nothing_but_errors_;
  for (const auto& bus : buses_) {
    // After a wait that brought errors alone, one round without the buses: an error that does not go away
    // must not keep this thread spinning.
    const int fd = nothing_but_errors_ ? -1 : bus->PollFd();
    retry = retry || fd < 0;
    descriptors.push_back({fd, kInput, 0});  // poll() ignores -1
  }
  if (retry && (timeout_ms < 0 || timeout_ms > kRetryMs)) timeout_ms = kRetryMs;
  const int ready = ::poll(descriptors.data(), descriptors.size(), timeout_ms);
  nothing_but_errors_ =
      ready > 0 && std::none_of(descriptors.begin(), descriptors.end(), [](const pollfd& entry) {
        return (static_cast<unsigned>(entry.revents) & static_cast<unsigned>(POLLIN)) != 0;
      });
}

std::optional<Frame> Network::Receive(int timeout_ms) noexcept {
  const bool endless = timeout_ms < 0;
  const Clock::time_point end = Clock::now() + std::chrono::milliseconds(std::max(timeout_ms, 0));
  while (!woken_.load()) {
    if (std::optional<Frame> frame = ReceiveNow()) {
      nothing_but_errors_ = false;
      return frame;
    }
    const int wait_ms = Remaining(end, endless);
    if (wait_ms == 0) return std::nullopt;
    WaitForInput(wait_ms);
  }
  return std::nullopt;
}

SendResult Network::Send(const Frame& frame) noexcept {
  SendResult worst = SendResult::kSent;
  for (const auto& bus : buses_) worst = std::max(worst, bus->Send(frame));
  return worst;
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
