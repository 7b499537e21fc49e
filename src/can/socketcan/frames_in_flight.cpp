#include "can/socketcan/frames_in_flight.hpp"

#include <linux/sock_diag.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <ctime>
#include "can/monotonic.hpp"

namespace servohil::can {
namespace {

/// Memory of frames that the socket has sent and the kernel still holds.
std::uint32_t BytesHeld(int socket) noexcept {
  std::array<std::uint32_t, SK_MEMINFO_VARS> memory{};
  socklen_t size = sizeof memory;
  if (::getsockopt(socket, SOL_SOCKET, SO_MEMINFO, memory.data(), &size) != 0) return 0;
  return memory[SK_MEMINFO_WMEM_ALLOC];
}

}  // namespace

bool FramesInFlight::AreStuck(int socket) noexcept {
  const std::uint32_t held = BytesHeld(socket);
  if (held == 0) return false;
  frame_bytes_ = frame_bytes_ == 0 ? held : std::min(frame_bytes_, held);
  const std::size_t frames = std::clamp<std::size_t>(held / frame_bytes_, 1, kMost);
  const std::int64_t oldest_ns = sent_ns_[(next_ + kMost - frames) % kMost];
  return MonotonicNs() - oldest_ns > kMaxAgeNs;
}

void FramesInFlight::AddOne() noexcept {
  sent_ns_[next_] = MonotonicNs();
  next_ = (next_ + 1) % kMost;
}

}  // namespace servohil::can
