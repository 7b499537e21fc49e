#include "servohil/model/steady_state.hpp"

#include <cmath>

#include "servohil/model/laws.hpp"
#include "servohil/model/step.hpp"

namespace servohil::model {
namespace {

/// Zero of an increasing function between low and high, to the last bit. @pre f(low) <= 0 <= f(high)
template <typename Function>
double IncreasingZero(const Function& f, double low, double high) {
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) break;
    (f(middle) < 0.0 ? low : high) = middle;
  }
  return std::fabs(f(low)) < std::fabs(f(high)) ? low : high;
}

SteadyState Failure(SteadyStateError error) noexcept {
  SteadyState none;
  none.error = error;
  return none;
}

}  // namespace

SteadyState SteadyStateAt(const Derived& d, double x3_in) noexcept {
  const double P3 = d.load.PressureAt(x3_in);  // (A.10)
  if (!(P3 < d.P2)) return Failure(SteadyStateError::kLoadAboveSupply);

  // (A.5), (A.6): plunger against bushing, x2 - x4, such that supply less drain is the leakage past the
  // piston.
  const auto surplus = [&](double x) noexcept {
    return OrificeFlow(d.P2 - P3, d.U + x, d.cr2, d.k_metering) -
           OrificeFlow(P3, d.U - x, d.cr2, d.k_metering) - d.c3 * P3;
  };
  // The plunger cannot be asked for more than P4 = 0 to P2 gives it, (A.2).
  const double lowest = -d.Fs / d.k2;
  const double highest = (d.P2 * d.A2 - d.Fs) / d.k2;
  if (!(surplus(lowest) <= 0.0 && surplus(highest) >= 0.0)) return Failure(SteadyStateError::kNoFlowBalance);
  const double x2_minus_x4 = IncreasingZero(surplus, lowest, highest);

  const double P4 = (d.k2 * x2_minus_x4 + d.Fs) / d.A2;  // (A.2)
  if (!(P4 > 0.0 && P4 < d.P2)) return Failure(SteadyStateError::kRelayPressureOutside);
  const double Q4 = CapillaryFlow(d.P2 - P4, d.capillary_a, d.capillary_b);  // (A.3)

  // (A.4), (A.9): the opening of the relay port that passes Q5 = Q4.
  const double effective_opening = Q4 / (d.k_relay * std::sqrt(P4));
  if (!(effective_opening > d.cr1)) return Failure(SteadyStateError::kRelayPortTooOpen);
  const double x2_minus_x1 = std::sqrt((effective_opening - d.cr1) * (effective_opening + d.cr1));

  SteadyState result;
  const double x1 = d.cam.At(x3_in) + x2_minus_x4 - x2_minus_x1;  // (A.11)
  result.p1_psi = x1 * d.k1 / d.A1;                               // (A.1)
  result.state = {x3_in, 0.0, P3, P4, P3, Motion::kFree};
  result.state.motion = MotionFromRest(d, result.state);
  result.outputs = ComputeOutputs(d, result.state, result.p1_psi);
  return result;
}

SteadyState SteadyStateForP1(const Derived& d, double p1_psi) noexcept {
  // P1 rises with x3 but for small dips where the load jumps, so search in steps much smaller than those.
  constexpr int kSteps = 800;
  const auto position = [&](int i) noexcept { return d.stroke_in * i / kSteps; };
  SteadyState below = SteadyStateAt(d, 0.0);
  for (int i = 1; i <= kSteps; ++i) {
    const SteadyState above = SteadyStateAt(d, position(i));
    if (below && above && below.p1_psi <= p1_psi && p1_psi <= above.p1_psi) {
      const auto excess = [&](double x3) noexcept { return SteadyStateAt(d, x3).p1_psi - p1_psi; };
      return SteadyStateAt(d, IncreasingZero(excess, position(i - 1), position(i)));
    }
    below = above;
  }
  return Failure(SteadyStateError::kNoPositionForP1);
}

}  // namespace servohil::model
