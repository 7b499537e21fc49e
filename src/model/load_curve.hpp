#pragma once
/// External steady-state load on the piston, thesis Figure 3 and Appendix E (FTABLE):
///   F_L(x3) = A3 p_L(x3),   p_L linear between the rows of a table; beyond them its end segments are
///   extended, or its end values held x3 [in]   p_L [psi]: the pressure under the piston that carries the
///   load at rest

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace servohil::model {

class LoadCurve {
 public:
  static constexpr std::size_t kMaxPoints = 254;  ///< of a table; two more where its ends are held

  struct Point {
    double x3_in = 0.0;
    double p3_psi = 0.0;
  };

  LoadCurve() = default;
  /// @pre 2 to kMaxPoints points, x3 strictly increasing, all finite (the reader of the file checks it)
  explicit LoadCurve(std::span<const Point> points) noexcept;

  /// The same curve with its end values held beyond its ends.
  LoadCurve Held() const noexcept;

  /// The same curve with so much more load everywhere [psi]. Real-time safe.
  LoadCurve Shifted(double psi) const noexcept;

  /// The same curve with `share` (0 to 1) of its rows' way to the load at `from_in`, of those rows that are
  /// above it and not above `to_in`. Real-time safe.
  LoadCurve HeldBetween(double from_in, double to_in, double share) const noexcept;

  /// p_L(x3) [psi]. Any finite x3. Real-time safe.
  double PressureAt(double x3_in) const noexcept {
    const std::size_t i = SegmentAt(x3_in);
    return p_[i] + (x3_in - x_[i]) * slope_[i];
  }
  /// dp_L/dx3 [psi/in], to the right of x3 where the slope jumps. Real-time safe.
  double SlopeAt(double x3_in) const noexcept { return slope_[SegmentAt(x3_in)]; }

  std::size_t size() const noexcept { return size_; }  // NOLINT(readability-identifier-naming): as in std
  Point operator[](std::size_t i) const noexcept { return {x_[i], p_[i]}; }

 private:
  static constexpr std::size_t kBins = 256;

  /// Index of the segment that holds x3: a uniform grid gives the first candidate, a few comparisons the
  /// segment.
  std::size_t SegmentAt(double x3_in) const noexcept {
    const double bin = (x3_in - x_[0]) * bins_per_in_;
    std::size_t i = !(bin > 0.0)           ? 0
                    : bin >= double{kBins} ? size_ - 2
                                           : first_segment_[static_cast<std::size_t>(bin)];
    while (i + 2 < size_ && x3_in >= x_[i + 1]) ++i;
    return i;
  }

  std::size_t size_ = 2;
  double bins_per_in_ = 0.0;
  std::array<double, kMaxPoints + 2> x_{0.0, 1.0};
  std::array<double, kMaxPoints + 2> p_{};
  std::array<double, kMaxPoints + 2> slope_{};
  std::array<std::uint8_t, kBins> first_segment_{};  ///< segment at the left edge of each bin
};

}  // namespace servohil::model
