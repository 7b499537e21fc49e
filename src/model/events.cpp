#include "model/events.hpp"

#include <algorithm>

#include "model/servomotor.hpp"

namespace servohil::model {
namespace {

constexpr Validator kNone = {1.0, 0.0};
enum GuardIndex : std::uint8_t {
  kPistonFirst,
  kPistonSecond,
  kPlungerLow,
  kPlungerHigh,
  kDiaphragm,
  kRelayPort
};

/// Drive forces at which a piston at rest breaks away [lbf].
double BreakawayUp(const Derived& d) noexcept {
  return d.F_breakaway;
}
double BreakawayDown(const Derived& d) noexcept {
  return -d.closing_ratio * d.F_breakaway;
}

Motion MotionUp(const Derived& d) noexcept {
  return d.directional ? Motion::kUp : Motion::kFree;
}
Motion MotionDown(const Derived& d) noexcept {
  return d.directional ? Motion::kDown : Motion::kFree;
}

/// Arrived at a stop: rests there, or leaves at once where its drive does not press it onto the stop.
State AtLowerStop(const Derived& d, State s) noexcept {
  s.x3_in = d.x3_low;
  s.v3_in_s = 0.0;
  s.mode.motion = DriveUp(d, s) > BreakawayUp(d) ? MotionUp(d) : Motion::kAtLowerStop;
  return s;
}
State AtUpperStop(const Derived& d, State s) noexcept {
  s.x3_in = d.x3_high;
  s.v3_in_s = 0.0;
  s.mode.motion = DriveDown(d, s) < BreakawayDown(d) ? MotionDown(d) : Motion::kAtUpperStop;
  return s;
}
/// Stopped between the stops.
State AtRest(const Derived& d, State s) noexcept {
  s.v3_in_s = 0.0;
  s.mode.motion = MotionFromRest(d, s);
  return s;
}

}  // namespace

Guards GuardsOf(const Derived& d, const State& s, double p1_psi, const StateVector& rates) noexcept {
  Guards g = {kNone, kNone, kNone, kNone, kNone, kNone};
  // At rest x3 and so the load are constant: a drive's rate is A3 dP3/dt.
  const double drive_rate = d.A3 * rates[kP3];
  const Validator holds_up = {BreakawayUp(d) - DriveUp(d, s), -drive_rate};
  const Validator holds_down = {DriveDown(d, s) - BreakawayDown(d), drive_rate};
  switch (s.mode.motion) {
    case Motion::kFree:
      g[kPistonFirst] = {s.x3_in - d.x3_low, s.v3_in_s};
      g[kPistonSecond] = {d.x3_high - s.x3_in, -s.v3_in_s};
      break;
    case Motion::kUp:
      g[kPistonFirst] = {s.v3_in_s, rates[kV3]};
      g[kPistonSecond] = {d.x3_high - s.x3_in, -s.v3_in_s};
      break;
    case Motion::kDown:
      g[kPistonFirst] = {-s.v3_in_s, -rates[kV3]};
      g[kPistonSecond] = {s.x3_in - d.x3_low, s.v3_in_s};
      break;
    case Motion::kStuck:
      g[kPistonFirst] = holds_up;
      g[kPistonSecond] = holds_down;
      break;
    case Motion::kAtLowerStop:
      g[kPistonFirst] = holds_up;
      break;
    case Motion::kAtUpperStop:
      g[kPistonFirst] = holds_down;
      break;
  }
  if (!d.full) return g;
  switch (s.mode.plunger) {
    case Plunger::kFree:
      g[kPlungerLow] = {s.p4_psi - d.plunger_low_psi, rates[kP4]};
      g[kPlungerHigh] = {d.plunger_high_psi - s.p4_psi, -rates[kP4]};
      break;
    case Plunger::kAtLowerStop:
      g[kPlungerLow] = {d.plunger_low_psi - s.p4_psi, -rates[kP4]};
      break;
    case Plunger::kAtUpperStop:
      g[kPlungerHigh] = {s.p4_psi - d.plunger_high_psi, rates[kP4]};
      break;
  }
  {
    const double sign = s.mode.relay_port_full ? -1.0 : 1.0;
    const double plunger_rate = s.mode.plunger == Plunger::kFree ? rates[kP4] * d.A2 / d.k2 : 0.0;
    g[kRelayPort] = {sign * (d.h_relay - RelayPortOpening(d, s, p1_psi)),
                     -sign * (plunger_rate + d.cam.SlopeAt(s.x3_in) * s.v3_in_s)};
  }
  if (d.stabilizer) {
    const double sign = s.mode.diaphragm_seated ? -1.0 : 1.0;
    g[kDiaphragm] = {sign * (s.p8_psi - d.precharge), sign * rates[kP8]};
  }
  return g;
}

bool AnyGuardEnded(const Derived& d, const State& state, double p1_psi) noexcept {
  const Guards guards = GuardsOf(d, state, p1_psi, StateVector::Zero());
  return std::any_of(guards.begin(), guards.end(), [](const Validator& g) { return g.value < 0.0; });
}

State AfterEvent(const Derived& d, const State& state, std::size_t index) noexcept {
  State s = state;
  if (index == kPlungerLow) {
    s.p4_psi = d.plunger_low_psi;
    s.mode.plunger = s.mode.plunger == Plunger::kFree ? Plunger::kAtLowerStop : Plunger::kFree;
    return s;
  }
  if (index == kPlungerHigh) {
    s.p4_psi = d.plunger_high_psi;
    s.mode.plunger = s.mode.plunger == Plunger::kFree ? Plunger::kAtUpperStop : Plunger::kFree;
    return s;
  }
  if (index == kDiaphragm) {
    s.p8_psi = d.precharge;
    s.mode.diaphragm_seated = !s.mode.diaphragm_seated;
    return s;
  }
  if (index == kRelayPort) {
    s.mode.relay_port_full = !s.mode.relay_port_full;
    return s;
  }
  const bool first = index == kPistonFirst;
  switch (s.mode.motion) {
    case Motion::kFree:
      return first ? AtLowerStop(d, s) : AtUpperStop(d, s);
    case Motion::kUp:
      return first ? AtRest(d, s) : AtUpperStop(d, s);
    case Motion::kDown:
      return first ? AtRest(d, s) : AtLowerStop(d, s);
    case Motion::kStuck:
      s.mode.motion = first ? Motion::kUp : Motion::kDown;
      return s;
    case Motion::kAtLowerStop:
      s.mode.motion = MotionUp(d);
      return s;
    case Motion::kAtUpperStop:
      s.mode.motion = MotionDown(d);
      return s;
  }
  return s;
}

Motion MotionFromRest(const Derived& d, const State& state) noexcept {
  if (!d.directional) return Motion::kFree;
  if (DriveUp(d, state) > BreakawayUp(d)) return Motion::kUp;
  if (DriveDown(d, state) < BreakawayDown(d)) return Motion::kDown;
  return Motion::kStuck;
}

}  // namespace servohil::model
