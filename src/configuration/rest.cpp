#include "configuration/rest.hpp"

#include <string>

#include "base/error.hpp"
#include "base/formatted.hpp"

namespace servohil::configuration {
namespace {

std::string Figure(double value) {
  return base::Formatted("%.6g", value);
}

/// Why there is no steady state, in words and numbers.
std::string Reason(const model::Derived& d, model::SteadyStateError error, double x3_in) {
  const double p3_psi = d.load_up.PressureAt(x3_in);
  const std::string at = "no steady state at x3 = " + Figure(x3_in) + " in: ";
  switch (error) {
    case model::SteadyStateError::kLoadAboveSupply:
      return at + "the load needs P3 = " + Figure(p3_psi) + " psi, the supply has " + Figure(d.P2) + " psi";
    case model::SteadyStateError::kNoFlowBalance:
      return at + "no plunger position balances supply, drain and leakage at P3 = " + Figure(p3_psi) + " psi";
    case model::SteadyStateError::kRelayPressureOutside:
      return at + "the plunger would need P4 outside 0 to " + Figure(d.P2) + " psi";
    case model::SteadyStateError::kRelayPortTooOpen:
      return at + "the relay port's clearance (servo.relay_piston_clearance_in = " + Figure(d.cr1) +
             " in) passes more than the capillary delivers";
    case model::SteadyStateError::kRelayPortTooSmall:
      return at + "the relay port, fully open at servo.relay_port_height_in = " + Figure(d.h_relay) +
             " in, passes less than the capillary delivers";
    case model::SteadyStateError::kPlungerAtStop:
      return at + "the plunger would have to be beyond servo.relay_plunger_travel_in = " +
             Figure(d.plunger_travel) + " in";
    case model::SteadyStateError::kRelayPistonAtStop:
      return at + "the relay piston would have to be outside 0 to servo.relay_piston_stroke_in = " +
             Figure(d.x1_stop) + " in";
    case model::SteadyStateError::kPumpTooSmall:
      return at + "supply.pump_flow_in3_s = " + Figure(d.pump_flow) +
             " in³/s is less than the servomotor consumes at rest";
    case model::SteadyStateError::kNone:
    case model::SteadyStateError::kNoPositionForP1:
      break;
  }
  return at + "none found";
}

}  // namespace

model::SteadyState RequireSteadyStateAt(const model::Derived& derived, double x3_in) {
  if (!(x3_in >= 0.0 && x3_in <= derived.stroke_in)) {
    throw base::UsageError("x3 = " + Figure(x3_in) +
                           " in: must be 0 to servo.stroke_in = " + Figure(derived.stroke_in) + " in");
  }
  const model::SteadyState state = model::SteadyStateAt(derived, x3_in);
  if (!state) throw base::UsageError(Reason(derived, state.error, x3_in));
  return state;
}

model::SteadyState RequireSteadyStateForP1(const model::Derived& derived, double p1_psi) {
  const model::SteadyState state = model::SteadyStateForP1(derived, p1_psi);
  if (state) return state;
  const model::SteadyState lowest = RequireSteadyStateAt(derived, 0.0);
  const model::SteadyState highest = RequireSteadyStateAt(derived, derived.stroke_in);
  throw base::UsageError("no steady state at P1 = " + Figure(p1_psi) + " psi: from x3 = 0 to " +
                         Figure(derived.stroke_in) + " in the piston rests at " + Figure(lowest.p1_psi) +
                         " to " + Figure(highest.p1_psi) + " psi");
}

}  // namespace servohil::configuration
