#pragma once
/// One of the two ways across threads: where every item counts. Bounded single-producer single-consumer queue
/// (indices that only grow, each side caching the other's, as in rigtorp's SPSCQueue); drops are counted.

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "rt/memory.hpp"

namespace servohil::rt {

/// One producer thread, one consumer thread. Real-time safe on both sides.
template <typename T, std::size_t kCapacity, typename Memory = StandardMemory>
class Ring {
  static_assert(std::is_trivially_copyable_v<T>);
  static_assert(std::has_single_bit(kCapacity));

 public:
  /// Producer. @return false when the ring was full: the item is dropped and counted
  bool TryPush(const T& item) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - cached_head_ == kCapacity) {
      cached_head_ = head_.load(std::memory_order_acquire);
      if (tail - cached_head_ == kCapacity) {
        dropped_.fetch_add(1, std::memory_order_relaxed);
        return false;
      }
    }
    items_[tail % kCapacity] = item;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Consumer. @return false when the ring is empty
  bool TryPop(T& item) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == cached_tail_) {
      cached_tail_ = tail_.load(std::memory_order_acquire);
      if (head == cached_tail_) return false;
    }
    item = items_[head % kCapacity];
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Any thread.
  std::uint64_t Dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  template <typename Value>
  using Atomic = typename Memory::template Atomic<Value>;

  std::array<typename Memory::template Cell<T>, kCapacity> items_{};
  alignas(64) Atomic<std::size_t> tail_{0};
  std::size_t cached_head_ = 0;  ///< producer's
  Atomic<std::uint64_t> dropped_{0};
  alignas(64) Atomic<std::size_t> head_{0};
  std::size_t cached_tail_ = 0;  ///< consumer's
};

}  // namespace servohil::rt
