#pragma once
/// Faults of the piston and of its load.
/// A part of the catalogue's table: read by catalogue.cpp alone.

#include "fault/parameter_acts.hpp"

namespace servohil::fault {

inline constexpr double kMaxPistonClearanceIn = 0.05;

inline void ForEachLoad(P& p, const auto& change) noexcept {
  p.load.opening = change(p.load.opening);
  if (p.load.has_closing) p.load.closing = change(p.load.closing);
}
inline void ShiftLoad(P& p, double psi) noexcept {
  ForEachLoad(p, [&](const model::LoadCurve& curve) { return curve.Shifted(psi); });
}

inline constexpr std::array kPistonAndLoadFaults = std::to_array<Spec>({
    {30,
     "coulomb_friction",
     Part::kPiston,
     {{{"psi", "psi", 0.0, 200.0, 10.0, "Coulomb friction, as a pressure under the piston"}}},
     "Dry friction holds the piston until the pressure overcomes it.",
     [](P& p, const V& v, double share, double) noexcept {
       p.friction.coulomb_psi = Toward(p.friction.coulomb_psi, v[0], share);
     }},
    {31,
     "stiction",
     Part::kPiston,
     {{{"psi", "psi", 0.0, 400.0, 20.0, "breakaway from rest, as a pressure under the piston"}}},
     "The piston sticks at rest and jumps when it breaks away.",
     [](P& p, const V& v, double share, double) noexcept {
       const double is = std::max(p.friction.breakaway_psi, p.friction.coulomb_psi);
       if (share > 0.0) p.friction.breakaway_psi = Toward(is, v[0], share);
     },
     Needs::kFullPhysics},
    {32,
     "piston_jammed",
     Part::kPiston,
     {},
     "The piston stops where it is and stays there, whatever the pressures.",
     [](P& p, const V&, double share, double) noexcept {
       constexpr double kMoreThanAnyPressurePsi = 20'000.0;
       p.friction.coulomb_psi = Toward(p.friction.coulomb_psi, kMoreThanAnyPressurePsi, share);
       p.friction.closing_ratio = Toward(p.friction.closing_ratio, 1.0, share);
     }},
    {33,
     "piston_leak",
     Part::kPiston,
     {{{"clearance_in", "in", 0.0, 0.02, 0.01, "more clearance of the piston, on diameter"}}},
     "Oil leaks past the piston: P3 sinks under load, the plunger must stay open to hold it.",
     [](P& p, const V& v, double share, double) noexcept {
       AddTo(p.servo.piston_clearance_in, share * v[0], 0.0, kMaxPistonClearanceIn);
     }},
    {40,
     "load_step",
     Part::kLoad,
     {{{"psi", "psi", -300.0, 300.0, 20.0, "more load, as a pressure under the piston"}}},
     "The load on the piston changes, at all positions alike.",
     [](P& p, const V& v, double share, double) noexcept { ShiftLoad(p, share * v[0]); }},
    {41,
     "load_oscillation",
     Part::kLoad,
     {{{"amplitude_psi", "psi", 0.0, 200.0, 10.0, "amplitude of the sine, as a pressure under the piston"},
       {"frequency_hz", "Hz", 0.01, 500.0, 10.0, "its frequency"}}},
     "The load on the piston oscillates, as steam flow in a valve makes it.",
     [](P& p, const V& v, double share, double t_s) noexcept { ShiftLoad(p, Sine(share * v[0], v[1], t_s)); },
     Needs::kNothing,
     true},
    {42,
     "stem_stuck",
     Part::kLoad,
     {{{"from_in", "in", 0.0, 100.0, 3.4, "piston position at which the stem has stuck"},
       {"over_in", "in", 0.25, 100.0, 1.6, "upward from there: over which part"}}},
     "A valve's stem is stuck: over a part of the stroke the load stays what it is at the part's beginning.",
     [](P& p, const V& v, double share, double) noexcept {
       ForEachLoad(
           p, [&](const model::LoadCurve& curve) { return curve.HeldBetween(v[0], v[0] + v[1], share); });
     }},
});

}  // namespace servohil::fault
