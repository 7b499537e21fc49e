#pragma once
/// Whether a controller has got stuck: it holds frames though nothing is wrong with the bus, as after a frame
/// was lost in an adapter. Only a reset ends that. No clock, no system call: whoever looks says when.

#include <algorithm>
#include <cstdint>

#include "can/bus_condition.hpp"

namespace servohil::can {

class ProgressWatch {
 public:
  /// @param tx_packets  that the interface has sent, as the kernel counts
  /// @return  true when a reset is due: after 5 s, then twice as long each time until frames go out
  bool IsResetDue(std::int64_t now_ns, const BusCondition& condition, std::uint64_t tx_packets) noexcept {
    // One that is not error-active has a reason not to send: nobody acknowledges, or the wires are broken.
    const bool stuck = condition.state == BusState::kErrorActive && condition.Has(BusFault::kQueueFull) &&
                       tx_packets == tx_packets_;
    if (tx_packets != tx_packets_) wait_ns_ = kFirstWaitNs;
    tx_packets_ = tx_packets;
    if (!stuck || since_ns_ == 0) since_ns_ = now_ns;
    if (now_ns - since_ns_ < wait_ns_) return false;
    since_ns_ = now_ns;
    wait_ns_ = std::min(2 * wait_ns_, kMaxWaitNs);
    return true;
  }

 private:
  /// Long beside any bus's longest wait: at 10 kbit/s a frame takes 15 ms.
  static constexpr std::int64_t kFirstWaitNs = 5'000'000'000;
  static constexpr std::int64_t kMaxWaitNs = 60'000'000'000;

  std::uint64_t tx_packets_ = 0;
  std::int64_t since_ns_ = 0;
  std::int64_t wait_ns_ = kFirstWaitNs;
};

}  // namespace servohil::can
