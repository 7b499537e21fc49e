#pragma once
/// Log-linear histogram of durations: 32 classes an octave, so that a quantile is high by at most 1/32 (3.1
/// %), and exact below 32 ns. Fixed size, no allocation (the principle of HdrHistogram).

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace servohil::rt {

class LatencyHistogram {
 public:
  /// Real-time safe. Negative durations count as 0.
  void Record(std::int64_t duration_ns) noexcept {
    const auto ns = static_cast<std::uint64_t>(duration_ns < 0 ? 0 : duration_ns);
    ++counts_[ClassOf(ns)];
    ++total_;
    if (ns > max_ns_) max_ns_ = ns;
  }

  std::uint64_t Count() const noexcept { return total_; }
  std::uint64_t MaxNs() const noexcept { return max_ns_; }

  /// Smallest class limit with at least `fraction` (0 to 1) of the durations at or below it, never above the
  /// maximum; 0 when nothing was recorded.
  std::uint64_t QuantileNs(double fraction) const noexcept {
    const double wanted = fraction * static_cast<double>(total_);
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < kClasses; ++i) {
      below += counts_[i];
      if (below != 0 && static_cast<double>(below) >= wanted)
        return UpperLimit(i) < max_ns_ ? UpperLimit(i) : max_ns_;
    }
    return max_ns_;
  }

 private:
  static constexpr unsigned kLinearBits = 5;  // 32 classes an octave
  static constexpr unsigned kOctaves = 64 - kLinearBits;
  static constexpr std::size_t kPerOctave = std::size_t{1} << kLinearBits;
  static constexpr std::size_t kClasses = (kOctaves + 1) * kPerOctave;

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

  std::array<std::uint64_t, kClasses> counts_{};
  std::uint64_t total_ = 0;
  std::uint64_t max_ns_ = 0;
};

}  // namespace servohil::rt
