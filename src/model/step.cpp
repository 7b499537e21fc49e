#include "servohil/model/step.hpp"

#include <algorithm>
#include <cmath>

#include "servohil/model/runge_kutta.hpp"
#include "servohil/model/servomotor.hpp"

namespace servohil::model {
namespace {

State Integrate(const Derived& d, const State& s, double p1_psi, double h_s) noexcept {
  const auto rates = [&](const StateVector& y) noexcept { return Rates(d, y, s.motion, p1_psi); };
  return State::From(RungeKutta4<StateVector>(rates, s.Vector(), h_s), s.motion);
}

/// First zero in [0, 1] of the cubic with values f0 > 0 (or 0 and rising), f1 < 0 and slopes m0, m1 at the
/// ends.
double HermiteZero(double f0, double m0, double f1, double m1) noexcept {
  if (f0 <= 0.0 && m0 <= 0.0) return 0.0;
  double low = 0.0;
  double high = 1.0;
  for (int i = 0; i < 40; ++i) {  // 2^-40 of a tick: 1e-16 s
    const double t = 0.5 * (low + high);
    const double u = 1.0 - t;
    const double f = u * u * (f0 * (1.0 + 2.0 * t) + m0 * t) + t * t * (f1 * (3.0 - 2.0 * t) - m1 * u);
    (f > 0.0 ? low : high) = t;
  }
  return 0.5 * (low + high);
}

/// Fraction of the step h at which the motion of `from` ends, given the state `to` at its end; above 1: not
/// in it.
double EventFraction(const Derived& d, const State& from, const State& to, double p1_psi,
                     double h_s) noexcept {
  constexpr double kNone = 2.0;
  switch (from.motion) {
    case Motion::kFree:
      return kNone;
    case Motion::kUp:
    case Motion::kDown: {
      const double sign = from.motion == Motion::kUp ? 1.0 : -1.0;
      if (!(sign * to.v3_in_s < 0.0)) return kNone;
      const double m0 = h_s * Rates(d, from.Vector(), from.motion, p1_psi)[kV3];
      const double m1 = h_s * Rates(d, to.Vector(), from.motion, p1_psi)[kV3];
      return HermiteZero(sign * from.v3_in_s, sign * m0, sign * to.v3_in_s, sign * m1);
    }
    case Motion::kStuck: {
      const double drive1 = DriveForce(d, to);
      const double drive0 = DriveForce(d, from);
      if (std::fabs(drive0) > d.F_coulomb) return 0.0;
      if (!(std::fabs(drive1) > d.F_coulomb)) return kNone;
      // At rest x3 and so the load are constant: the drive's rate is A3 dP3/dt.
      const double sign = std::copysign(1.0, drive1);
      const double m0 = h_s * d.A3 * Rates(d, from.Vector(), from.motion, p1_psi)[kP3];
      const double m1 = h_s * d.A3 * Rates(d, to.Vector(), from.motion, p1_psi)[kP3];
      return HermiteZero(d.F_coulomb - sign * drive0, -sign * m0, d.F_coulomb - sign * drive1, -sign * m1);
    }
  }
  return kNone;
}

/// Sub-steps that the state asks for: at least 1, more than kMaxSubSteps where that would not do.
int WantedSubSteps(const Derived& d, const State& s, double p1_psi, double h_s) noexcept {
  const double wanted = h_s * FastestRate(d, s, p1_psi);
  if (wanted <= 1.0) return 1;
  // Also where a pressure difference is 0 and the rate infinite or not a number.
  if (!(wanted <= kMaxSubSteps)) return kMaxSubSteps + 1;
  return static_cast<int>(std::ceil(wanted));
}

State SubStep(const Derived& d, const State& state, double p1_psi, double h_s) noexcept {
  State s = state;
  double left_s = h_s;
  for (int event = 0; event < kMaxEventsPerSubStep; ++event) {
    const State end = Integrate(d, s, p1_psi, left_s);
    const double fraction = EventFraction(d, s, end, p1_psi, left_s);
    if (fraction > 1.0) return end;
    const double until_event_s = fraction * left_s;
    if (until_event_s > 0.0) s = Integrate(d, s, p1_psi, until_event_s);
    left_s -= until_event_s;
    if (s.motion == Motion::kStuck) {
      // The root is where the drive passes breakaway; rounding must not leave the piston stuck there.
      s.motion = DriveForce(d, s) > 0.0 ? Motion::kUp : Motion::kDown;
    } else {
      s.v3_in_s = 0.0;
      s.motion = MotionFromRest(d, s);
    }
  }
  s.v3_in_s = 0.0;
  s.motion = Motion::kStuck;
  return Integrate(d, s, p1_psi, left_s);
}

}  // namespace

Motion MotionFromRest(const Derived& d, const State& state) noexcept {
  if (d.F_coulomb == 0.0) return Motion::kFree;
  const double drive = DriveForce(d, state);
  if (std::fabs(drive) <= d.F_coulomb) return Motion::kStuck;
  return drive > 0.0 ? Motion::kUp : Motion::kDown;
}

StepResult Step(const Derived& d, const State& state, double p1_psi, double h_s) noexcept {
  const int wanted = WantedSubSteps(d, state, p1_psi, h_s);
  StepResult result{state, std::min(wanted, kMaxSubSteps), wanted <= kMaxSubSteps};
  for (int i = 0; i < result.sub_steps; ++i)
    result.state = SubStep(d, result.state, p1_psi, h_s / result.sub_steps);
  return result;
}

}  // namespace servohil::model
