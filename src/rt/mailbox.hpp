#pragma once
/// One of the two ways across threads: where only the newest value counts. Wait-free triple buffer: the
/// producer always has a slot of its own, the consumer keeps the one that it reads, the third changes hands
/// atomically.

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

#include "rt/memory.hpp"

namespace servohil::rt {

/// One producer thread, one consumer thread. Real-time safe on both sides.
template <typename T, typename Memory = StandardMemory>
class Mailbox {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  /// Producer: replaces whatever has not been taken yet.
  void Put(const T& value) noexcept {
    slots_[write_].value = value;
    write_ = shared_.exchange(static_cast<std::uint8_t>(write_ | kFresh), std::memory_order_acq_rel) & kIndex;
  }

  /// Consumer: the newest value put since the last Take().
  /// @return false when there is none; `value` is then left as it is
  bool Take(T& value) noexcept {
    if ((shared_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    read_ = shared_.exchange(read_, std::memory_order_acq_rel) & kIndex;
    value = slots_[read_].value;
    return true;
  }

 private:
  static constexpr std::uint8_t kFresh = 4;
  static constexpr std::uint8_t kIndex = 3;
  struct alignas(64) Slot {
    typename Memory::template Cell<T> value{};
  };

  std::array<Slot, 3> slots_{};
  alignas(64) typename Memory::template Atomic<std::uint8_t> shared_{1};
  alignas(64) std::uint8_t write_ = 0;  ///< producer's
  alignas(64) std::uint8_t read_ = 2;   ///< consumer's
};

}  // namespace servohil::rt
