#pragma once
/// Response of x3 (and of all states) to a step of 1 psi in P1, from rest. Exact at its sample times: the
/// step from one to the next is the matrix exponential (Taylor series with scaling and squaring).

#include <cmath>
#include <limits>

#include "linear/linear_system.hpp"

namespace servohil::linear {

class StepResponse {
 public:
  /// @param interval_s  between samples
  StepResponse(const LinearSystem& system, double interval_s) noexcept;

  /// States at the present sample, as changes from the operating point, per psi.
  const LinearVector& Now() const noexcept { return state_; }
  void Advance() noexcept { state_ = transition_ * state_ + input_; }

 private:
  LinearMatrix transition_;
  LinearVector input_;
  LinearVector state_;
};

/// NaN where there is none: an unstable system has no final value.
struct StepFigures {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  double final_in_psi = kNone;  ///< x3 / P1 as t → infinity [in/psi]
  double rise_s = kNone;      ///< first time at 95 % of the final value, the thesis' definition (section 3.5)
  double overshoot = kNone;   ///< (largest - final) / final, at least 0
  double settling_s = kNone;  ///< last time outside ± 2 % of the final value
};

/// From samples 1/50 rad of the fastest mode apart, crossings interpolated linearly: good to 1e-4 of each
/// figure. Followed until the slowest mode has decayed to 5e-5, at most 5 million samples.
StepFigures FindStepFigures(const LinearSystem& system) noexcept;

}  // namespace servohil::linear
