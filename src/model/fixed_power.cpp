#include "model/fixed_power.hpp"

namespace servohil::model {

FixedPower::FixedPower(double q) noexcept : q_(q) {
  double coefficient = 1.0;
  for (std::size_t i = 0; i < binomial_.size(); ++i) {
    const auto n = static_cast<double>(i);
    coefficient *= (q - n) / (n + 1.0);
    binomial_[i] = coefficient;
  }
  for (std::size_t i = 0; i < kParts; ++i) {
    const double middle = 1.0 + (static_cast<double>(i) + 0.5) / kParts;
    inverse_middle_[i] = 1.0 / middle;
    // of the reciprocal that is used, not of the middle: its rounding cancels
    middle_power_[i] = std::pow(1.0 / inverse_middle_[i], q);
  }
  for (std::size_t i = 0; i < kOctaves; ++i)
    octave_power_[i] = std::pow(std::ldexp(1.0, static_cast<int>(i) - static_cast<int>(kOctaves / 2)), q);
}

}  // namespace servohil::model
