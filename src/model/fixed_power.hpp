#pragma once
/// x^q for an exponent q that does not change, a quarter of std::pow's time: x = 2^e m, m in [1, 2), and
///   x^q = (2^e)^q c^q (m/c)^q
/// with the first two factors from tables (c: middle of one of 128 parts of [1, 2)) and the third by its
/// binomial series about 1. |m/c - 1| <= 1/257, so that for -2 <= q <= 2 what follows u⁵ is below 7/257⁶:
/// relative error below 1e-13. Beyond 2^±20, and for 0, negative or not finite x: std::pow. Real-time safe.

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace servohil::model {

class FixedPower {
 public:
  /// @pre -2 <= q <= 2
  explicit FixedPower(double q) noexcept;

  double operator()(double x) const noexcept {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const std::size_t octave = (bits >> 52) - kFirstOctave;
    if (octave >= kOctaves) return std::pow(x, q_);
    const std::size_t part = (bits >> 45) & (kParts - 1);
    const auto m = std::bit_cast<double>((bits & 0x000F'FFFF'FFFF'FFFF) | 0x3FF0'0000'0000'0000);
    const double u = m * inverse_middle_[part] - 1.0;
    const double series =
        1.0 +
        u * (binomial_[0] + u * (binomial_[1] + u * (binomial_[2] + u * (binomial_[3] + u * binomial_[4]))));
    return octave_power_[octave] * middle_power_[part] * series;
  }

 private:
  static constexpr std::size_t kParts = 128;
  static constexpr std::size_t kOctaves = 40;
  static constexpr std::size_t kFirstOctave = 1023 - kOctaves / 2;  ///< biased, as in the bits

  double q_;
  std::array<double, 5> binomial_{};
  std::array<double, kParts> inverse_middle_{};
  std::array<double, kParts> middle_power_{};
  std::array<double, kOctaves> octave_power_{};
};

}  // namespace servohil::model
