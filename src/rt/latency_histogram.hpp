#pragma once
/// Log-linear histogram of durations: 32 classes an octave, so that a quantile is high by at most 1/32 (3.1
/// %), and exact below 32 ns. Fixed size, no allocation (the principle of HdrHistogram). One thread records;
/// any may read meanwhile, and sees each count as it was at some moment.

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace servohil::rt {

class LatencyHistogram {
 public:
  /// Real-time safe. Negative durations count as 0.
  void Record(std::int64_t duration_ns) noexcept {
    const auto ns = static_cast<std::uint64_t>(duration_ns < 0 ? 0 : duration_ns);
    Increment(counts_[ClassOf(ns)]);
    Increment(total_);
    if (ns > MaxNs()) max_ns_.store(ns, std::memory_order_relaxed);
  }

  std::uint64_t Count() const noexcept { return total_.load(std::memory_order_relaxed); }
  std::uint64_t MaxNs() const noexcept { return max_ns_.load(std::memory_order_relaxed); }

  /// Smallest class limit with at least `fraction` (0 to 1) of the durations at or below it, never above the
  /// maximum; 0 when nothing was recorded.
  std::uint64_t QuantileNs(double fraction) const noexcept {
    const double wanted = fraction * static_cast<double>(Count());
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < kClasses; ++i) {
      below += counts_[i].load(std::memory_order_relaxed);
      if (below != 0 && static_cast<double>(below) >= wanted) return std::min(UpperLimit(i), MaxNs());
    }
    return MaxNs();
  }

 private:
  static constexpr unsigned kLinearBits = 5;  // 32 classes an octave
  static constexpr unsigned kOctaves = 64 - kLinearBits;
  static constexpr std::size_t kPerOctave = std::size_t{1} << kLinearBits;
  static constexpr std::size_t kClasses = (kOctaves + 1) * kPerOctave;

  using Counter = std::atomic<std::uint64_t>;
  /// Of a counter with one writer: no locked instruction.
  static void Increment(Counter& counter) noexcept {
    counter.store(counter.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

  static std::size_t ClassOf(std::uint64_t ns) noexcept {
    if (ns < kPerOctave) return ns;
    const auto octave = static_cast<unsigned>(std::bit_width(ns)) - kLinearBits - 1;
    return (octave + 1) * kPerOctave + ((ns >> octave) - kPerOctave);
  }
  static std::uint64_t UpperLimit(std::size_t i) noexcept {
    if (i < kPerOctave) return i;
    const std::size_t octave = i / kPerOctave - 1;
    return ((kPerOctave + i % kPerOctave + 1) << octave) - 1;
  }

  std::array<Counter, kClasses> counts_{};
  Counter total_{0};
  Counter max_ns_{0};
};

}  // namespace servohil::rt
