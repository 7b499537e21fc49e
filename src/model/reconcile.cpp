#include "model/reconcile.hpp"

#include "model/events.hpp"
#include "model/servomotor.hpp"

namespace servohil::model {
namespace {

Motion MotionOf(const Derived& d, const State& s) noexcept {
  if (s.mode.motion == Motion::kAtLowerStop || s.mode.motion == Motion::kAtUpperStop) return s.mode.motion;
  if (!d.directional) return Motion::kFree;
  if (s.v3_in_s > 0.0) return Motion::kUp;
  if (s.v3_in_s < 0.0) return Motion::kDown;
  return MotionFromRest(d, s);
}

Plunger PlungerOf(const Derived& d, const State& s) noexcept {
  if (s.p4_psi <= d.plunger_low_psi) return Plunger::kAtLowerStop;
  if (s.p4_psi >= d.plunger_high_psi) return Plunger::kAtUpperStop;
  return Plunger::kFree;
}

}  // namespace

State Reconciled(const Derived& d, const State& state, double p1_psi) noexcept {
  State s = state;
  if (d.pump_flow == 0.0) s.p2_psi = d.P2;
  if (!d.stabilizer) s.p8_psi = s.p3_psi;
  s.mode.motion = MotionOf(d, s);
  s.mode.diaphragm_seated = d.stabilizer && s.p8_psi < d.precharge;
  if (!d.full) return s;
  s.mode.plunger = PlungerOf(d, s);
  s.mode.relay_port_full = RelayPortOpening(d, s, p1_psi) > d.h_relay;
  return s;
}

}  // namespace servohil::model
