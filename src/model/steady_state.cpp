#include "model/steady_state.hpp"

#include <algorithm>
#include <cmath>

#include "model/laws.hpp"
#include "model/step.hpp"

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

double MeteringFlow(const Derived& d, double dP, double opening) noexcept {
  if (!d.full) return OrificeFlow(dP, opening, d.cr2, d.k_metering);
  return dP *
         OrificeConductance(dP, OpeningSquared(opening, d.cr2, d.h_metering), d.k_metering, d.p_transition);
}

/// The relay and its supply at rest: all that follows from P2 and P3.
struct Relay {
  SteadyStateError error = SteadyStateError::kNone;
  double x2_minus_x4 = 0.0;
  double x2_minus_x1 = 0.0;
  double P4 = 0.0;
  double consumption = 0.0;  ///< Q3 + Q4 [in³/s]
};

Relay RelayAt(const Derived& d, double P2, double P3) noexcept {
  Relay r;
  if (!(P3 < P2)) return r.error = SteadyStateError::kLoadAboveSupply, r;
  // (A.5), (A.6): plunger against bushing, x2 - x4, such that supply less drain is the leakage past the
  // piston.
  const auto surplus = [&](double x) noexcept {
    return MeteringFlow(d, P2 - P3, d.U + x) - MeteringFlow(d, P3 - d.Pe, d.U - x) - d.c3 * (P3 - d.Pe);
  };
  // The plunger cannot be asked for more than P4 = 0 to P2 gives it, (A.2).
  const double lowest = -d.Fs / d.k2;
  const double highest = (P2 * d.A2 - d.Fs) / d.k2;
  if (!(surplus(lowest) <= 0.0 && surplus(highest) >= 0.0))
    return r.error = SteadyStateError::kNoFlowBalance, r;
  r.x2_minus_x4 = IncreasingZero(surplus, lowest, highest);
  if (d.full && std::fabs(r.x2_minus_x4) > d.plunger_travel)
    return r.error = SteadyStateError::kPlungerAtStop, r;

  r.P4 = (d.k2 * r.x2_minus_x4 + d.Fs) / d.A2;  // (A.2)
  if (!(r.P4 > d.Pe && r.P4 < P2)) return r.error = SteadyStateError::kRelayPressureOutside, r;
  const double Q4 = CapillaryFlow(P2 - r.P4, d.capillary_a, d.capillary_b);  // (A.3)

  // (A.4), (A.9): the opening of the relay port that passes Q5 = Q4.
  const double dP = r.P4 - d.Pe;
  const double effective_opening = d.full ? Q4 / (dP * OrificeConductance(dP, 1.0, d.k_relay, d.p_transition))
                                          : Q4 / (d.k_relay * std::sqrt(r.P4));
  if (!(effective_opening > d.cr1)) return r.error = SteadyStateError::kRelayPortTooOpen, r;
  r.x2_minus_x1 = std::sqrt((effective_opening - d.cr1) * (effective_opening + d.cr1));
  if (r.x2_minus_x1 > d.h_relay) return r.error = SteadyStateError::kRelayPortTooSmall, r;
  r.consumption = MeteringFlow(d, P2 - P3, d.U + r.x2_minus_x4) + Q4;
  return r;
}

/// Supply pressure at rest: where the pump delivers what is consumed.
double SupplyAtRest(const Derived& d, double P3) noexcept {
  if (d.pump_flow <= 0.0) return d.P2;
  const double lowest = d.P2 - 1.0 / d.inverse_band;  // the pump delivers all it can
  const auto lack = [&](double P2) noexcept {
    const double delivered = d.pump_flow * std::min(1.0, (d.P2 - P2) * d.inverse_band);
    const Relay relay = RelayAt(d, P2, P3);
    return (relay.error == SteadyStateError::kNone ? relay.consumption : 0.0) - delivered;
  };
  return lack(lowest) <= 0.0 ? IncreasingZero(lack, lowest, d.P2) : std::nan("");
}

}  // namespace

SteadyState SteadyStateAt(const Derived& d, double x3_in) noexcept {
  const double P3 = d.load_up.PressureAt(x3_in);  // (A.10)
  const double P2 = SupplyAtRest(d, P3);
  if (std::isnan(P2)) return Failure(SteadyStateError::kPumpTooSmall);
  const Relay relay = RelayAt(d, P2, P3);
  if (relay.error != SteadyStateError::kNone) return Failure(relay.error);

  SteadyState result;
  const double x1 = d.cam.At(x3_in) + relay.x2_minus_x4 - relay.x2_minus_x1;  // (A.11)
  if (d.full && !(x1 >= 0.0 && x1 <= d.x1_stop)) return Failure(SteadyStateError::kRelayPistonAtStop);
  result.p1_psi = x1 * d.k1 / d.A1;  // (A.1)
  result.state = {x3_in, 0.0, P3, relay.P4, P3, P2, {}};
  result.state.mode = ModeAtRest(d, result.state);
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
