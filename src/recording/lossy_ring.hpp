#pragma once
/// A ring whose consumer learns where items were lost.

#include <atomic>
#include <cstdint>
#include <ctime>
#include <memory>

#include "rt/ring.hpp"

namespace servohil::recording {

/// One producer thread, one consumer thread.
template <typename T, std::size_t kCapacity>
class LossyRing {
 public:
  struct Loss {
    std::uint64_t lost = 0;
    std::uint64_t first_tick = 0;  ///< of the first one lost
  };
  struct Entry {
    T item;
    Loss before;  ///< between this item and the one before it
  };

  /// Producer. Wait-free, real-time safe. @param tick  when, should it be lost. @return false when lost
  bool Push(std::uint64_t tick, const T& item) noexcept {
    if (ring_->TryPush({item, loss_})) {
      loss_ = {};
      return true;
    }
    if (loss_.lost++ == 0) loss_.first_tick = tick;
    lost_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  /// Producer that may wait: sleeps until there is room.
  void PushWaiting(const T& item) noexcept {
    constexpr timespec kWait{.tv_sec = 0, .tv_nsec = 200'000};
    while (!ring_->TryPush({item, {}})) nanosleep(&kWait, nullptr);
  }

  /// Consumer.
  bool TryPop(Entry& entry) noexcept { return ring_->TryPop(entry); }
  /// What was lost after the last item; after the producer has ended.
  Loss LostAtEnd() const noexcept { return loss_; }
  /// Any thread: lost so far.
  std::uint64_t Lost() const noexcept { return lost_.load(std::memory_order_relaxed); }

 private:
  using Items = rt::Ring<Entry, kCapacity>;
  std::unique_ptr<Items> ring_ = std::make_unique<Items>();
  Loss loss_;                           ///< producer's: since the last item
  std::atomic<std::uint64_t> lost_{0};  ///< not the ring's count: that has the tries of one who waits, too
};

}  // namespace servohil::recording
