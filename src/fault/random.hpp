#pragma once
/// Randomness that depends on nothing but what it is for: the n-th number of a key is always the same one,
/// whichever thread asks for it, and whatever was asked before.

#include <cmath>
#include <cstdint>
#include <numbers>

namespace servohil::fault {

/// SplitMix64 (Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014).
/// Real-time safe.
class Random {
 public:
  /// Another sequence for each seed, fault, target and moment.
  Random(std::uint64_t seed, std::uint8_t fault, std::uint8_t target, std::uint64_t moment) noexcept
      : state_(Mixed(Mixed(Mixed(seed) ^ (std::uint64_t{fault} << 8U | target)) ^ moment)) {}

  std::uint64_t Next() noexcept { return Mixed(state_ += kStep); }
  /// 0 <= u < 1, in steps of 2^-53.
  double Uniform() noexcept { return static_cast<double>(Next() >> 11U) * 0x1p-53; }
  bool Chance(double probability) noexcept { return Uniform() < probability; }
  /// Mean 0, standard deviation 1 (Box and Muller): at most 8.6.
  double Normal() noexcept {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * Uniform());
  }

 private:
  static constexpr std::uint64_t kStep = 0x9E3779B97F4A7C15U;
  static std::uint64_t Mixed(std::uint64_t z) noexcept {
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31U);
  }

  std::uint64_t state_;
};

}  // namespace servohil::fault
