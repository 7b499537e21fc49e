#include "model/step.hpp"

#include <algorithm>
#include <cmath>

#include "model/events.hpp"
#include "model/rosenbrock.hpp"
#include "model/runge_kutta.hpp"
#include "model/servomotor.hpp"

namespace servohil::model {
namespace {

/// What a step needs besides the state.
struct Context {
  const Derived& d;
  double p1_psi;
  bool stiff;
};

/// @param now  rates at s
State Integrate(const Context& c, const State& s, const StateVector& now, double h_s) noexcept {
  const auto rates = [&](const StateVector& y) noexcept { return Rates(c.d, y, s.mode, c.p1_psi); };
  if (!c.stiff) return State::From(RungeKutta4<StateVector>(rates, s.Vector(), now, h_s), s.mode);
  StateVector scale;  // of x3, v3 and the pressures: inch, inch per second, psi
  scale << 1.0, 1.0, 1.0, 0.1, 1.0, 1.0;
  StateVector y = Rodas3<StateVector>(rates, s.Vector(), now, h_s, scale);
  if (s.mode.PistonRests()) {  // to the last bit, whatever the linear solver rounds
    y[kX3] = s.x3_in;
    y[kV3] = 0.0;
  }
  if (!c.d.stabilizer) y[kP8] = y[kP3];
  return State::From(y, s.mode);
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

struct Event {
  double fraction = 2.0;  ///< of the sub-step; above 1: none
  std::size_t validator = 0;
};

/// The first event between two states of one mode.
/// @param now  rates at `from`
Event FirstEvent(const Context& c, const State& from, const StateVector& now, const State& to,
                 double h_s) noexcept {
  if (!AnyGuardEnded(c.d, to, c.p1_psi)) return {};
  const Guards end = GuardsOf(c.d, to, c.p1_psi, Rates(c.d, to.Vector(), to.mode, c.p1_psi));
  const Guards begin = GuardsOf(c.d, from, c.p1_psi, now);
  Event first;
  for (std::size_t i = 0; i < end.size(); ++i) {
    if (!(end[i].value < 0.0)) continue;
    const double fraction = HermiteZero(begin[i].value, h_s * begin[i].rate, end[i].value, h_s * end[i].rate);
    if (fraction < first.fraction) first = {fraction, i};
  }
  return first;
}

/// How to go on from a state.
struct Plan {
  double sub_steps;  ///< for what is left of the step
  bool stiff;
};

Plan PlanFor(const Derived& d, const TimeScales& scales, double left_s, double h_s) noexcept {
  double wanted = left_s * scales.FastestMode() / kRateTimesSubStep;
  // The comparison is false where the rate is not a number.
  const bool stiff = d.full && !(wanted * h_s <= kMaxRungeKuttaSubSteps * left_s);
  if (stiff) wanted = kRosenbrockSubSteps * left_s / h_s;
  wanted = std::max({1.0, wanted, left_s * scales.stiffness / kStiffnessShare, left_s * scales.ports});
  return {wanted > 1.0 ? std::ceil(wanted) : 1.0, stiff};
}

/// Holds the piston for what is left of the step; the next one begins at rest.
void Hold(State& s) noexcept {
  s.v3_in_s = 0.0;
  if (!s.mode.PistonRests()) s.mode.motion = Motion::kStuck;
}

}  // namespace

Mode ModeAtRest(const Derived& d, const State& state) noexcept {
  Mode mode = MotionFromRest(d, state);
  mode.diaphragm_seated = d.stabilizer && state.p8_psi < d.precharge;
  return mode;
}

StepResult Step(const Derived& d, const State& state, double p1_psi, double h_s) noexcept {
  StepResult result{state};
  State& s = result.state;
  int events = 0;
  for (double left_s = h_s; left_s > 0.0;) {
    const auto [rates, scales] = RatesAndScalesAt(d, s, p1_psi);
    const Plan plan = PlanFor(d, scales, left_s, h_s);
    const double budget = std::max(1.0, static_cast<double>(kMaxSubSteps + events - result.sub_steps));
    if (!(plan.sub_steps <= budget)) result.resolved = false;
    const double wanted = plan.sub_steps <= budget ? plan.sub_steps : budget;

    const Context context = {d, p1_psi, plan.stiff};
    const double sub_step_s = left_s / wanted;
    const State end = Integrate(context, s, rates, sub_step_s);
    const Event event = events < kMaxEvents ? FirstEvent(context, s, rates, end, sub_step_s) : Event{};
    ++result.sub_steps;
    if (event.fraction > 1.0) {
      s = end;
      left_s = wanted <= 1.0 ? 0.0 : left_s - sub_step_s;
      continue;
    }
    const double until_event_s = event.fraction * sub_step_s;
    if (until_event_s > 0.0) s = Integrate(context, s, rates, until_event_s);
    s = AfterEvent(d, s, event.validator);
    left_s -= until_event_s;
    if (++events == kMaxEvents) Hold(s);
  }
  return result;
}

}  // namespace servohil::model
