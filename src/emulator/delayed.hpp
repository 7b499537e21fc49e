#pragma once
/// Things that have to wait for their tick.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace servohil::emulator {

/// One thread. Bounded; real-time safe after construction.
template <typename T>
class Delayed {
 public:
  explicit Delayed(std::size_t most) : most_(most) { waiting_.reserve(most); }

  bool Empty() const noexcept { return waiting_.empty(); }
  /// @return false: there is no room
  bool Push(std::uint64_t due_tick, const T& item) noexcept {
    if (waiting_.size() == most_) return false;
    waiting_.push_back({due_tick, item});
    return true;
  }
  /// The next that is due at `tick`: by their ticks, of one tick as they came. @return false: there is none
  bool TryPop(std::uint64_t tick, T& item) noexcept {
    const auto first = std::min_element(waiting_.begin(), waiting_.end(), [](const Entry& a, const Entry& b) {
      return a.due_tick < b.due_tick;
    });
    if (first == waiting_.end() || first->due_tick > tick) return false;
    item = first->item;
    waiting_.erase(first);
    return true;
  }

 private:
  struct Entry {
    std::uint64_t due_tick;
    T item;
  };
  std::size_t most_;
  std::vector<Entry> waiting_;
};

}  // namespace servohil::emulator
