#pragma once

#include <atomic>
#include <cstdint>

#include "can/bus.hpp"

namespace servohil::can {

/// BusStatistics that several threads add to. Each total is exact; between two of them a reader may see one
/// frame of difference.
struct Counters {
  std::atomic<std::uint64_t> received{0};
  std::atomic<std::uint64_t> sent{0};
  std::atomic<std::uint64_t> dropped_queue_full{0};
  std::atomic<std::uint64_t> dropped_disconnected{0};
  std::atomic<std::uint64_t> receive_overflows{0};
  std::atomic<std::uint64_t> malformed{0};
  std::atomic<std::uint64_t> error_frames{0};

  static void Add(std::atomic<std::uint64_t>& counter, std::uint64_t n = 1) noexcept {
    counter.fetch_add(n, std::memory_order_relaxed);
  }

  /// Counts the outcome of one Send() and passes it through.
  SendResult Count(SendResult result) noexcept {
    switch (result) {
      case SendResult::kSent:
        Add(sent);
        break;
      case SendResult::kQueueFull:
        Add(dropped_queue_full);
        break;
      case SendResult::kDisconnected:
        Add(dropped_disconnected);
        break;
    }
    return result;
  }

  BusStatistics Snapshot() const noexcept {
    constexpr auto kRelaxed = std::memory_order_relaxed;
    return {received.load(kRelaxed),           sent.load(kRelaxed),
            dropped_queue_full.load(kRelaxed), dropped_disconnected.load(kRelaxed),
            receive_overflows.load(kRelaxed),  malformed.load(kRelaxed),
            error_frames.load(kRelaxed)};
  }
};

}  // namespace servohil::can
