#pragma once
/// Faults of the relay: its valve, springs and cam.
/// A part of the catalogue's table: read by catalogue.cpp alone.

#include "fault/parameter_acts.hpp"

namespace servohil::fault {

inline constexpr double kLeastSpringLbfIn = 0.1;
inline constexpr double kMaxUnderlapIn = 0.05;
inline constexpr double kMaxClearanceIn = 0.02;
inline constexpr double kLeastAlpha = 0.01;
inline constexpr double kLeastPortWidthIn = 0.01;

inline void MoveCam(P& p, double offset_in) noexcept {
  p.cam.x3_star_in += offset_in;
  p.cam.lower_x3_star_in += offset_in;
  p.cam.upper_x3_star_in += offset_in;
}

/// A spring so stiff, and so preloaded, that no pressure moves the plunger from there.
inline void StickPlunger(P& p, double opening_in) noexcept {
  constexpr double kStuckLbfIn = 1e9;
  const double travel_in = p.servo.relay_plunger_travel_in;
  p.servo.main_spring_rate_lbf_in = kStuckLbfIn;
  p.servo.main_spring_preload_lbf = -kStuckLbfIn * std::clamp(opening_in, -travel_in, travel_in);
}

/// Between stops that leave no room.
inline void HoldRelayPiston(P& p, double x1_in) noexcept {
  p.servo.relay_piston_stroke_in = std::min(p.servo.relay_piston_stroke_in, x1_in);
  p.servo.relay_piston_lowest_in = p.servo.relay_piston_stroke_in;
}

inline constexpr std::array kRelayFaults = std::to_array<Spec>({
    {20,
     "capillary_plugged",
     Part::kRelay,
     {{{"area_lost", "", 0.0, 0.99, 0.5, "share of the capillary's area that is lost"}}},
     "The capillary through the relay plunger clogs: P4 rises more slowly, the piston opens more slowly.",
     [](P& p, const V& v, double share, double) noexcept {
       Plug(p.servo.capillary_diameter_in, share * v[0]);
     }},
    {21,
     "relay_port_silted",
     Part::kRelay,
     {{{"width_lost", "", 0.0, 0.99, 0.5, "share of the relay ports' width that is lost"}}},
     "The relay's ports silt up: they must open farther to pass the same flow, P4 falls more slowly.",
     [](P& p, const V& v, double share, double) noexcept {
       Lose(p.servo.relay_port_width_in, share * v[0], kLeastPortWidthIn);
     }},
    {22,
     "plunger_worn",
     Part::kRelay,
     {{{"clearance_in", "in", 0.0, 0.01, 0.002, "more radial clearance of the relay plunger"},
       {"underlap_in", "in", 0.0, 0.02, 0.002, "more underlap"}}},
     "The relay plunger's edges are worn: more oil leaks at rest, the metering is softer.",
     [](P& p, const V& v, double share, double) noexcept {
       AddTo(p.servo.relay_plunger_clearance_in, share * v[0], 0.0, kMaxClearanceIn);
       AddTo(p.servo.underlap_in, share * v[1], -kMaxUnderlapIn, kMaxUnderlapIn);
     }},
    {23,
     "plunger_overlapped",
     Part::kRelay,
     {{{"overlap_in", "in", 0.0, 0.02, 0.004, "less underlap"}}},
     "The relay plunger overlaps its ports: a dead band in which the piston is not metered.",
     [](P& p, const V& v, double share, double) noexcept {
       AddTo(p.servo.underlap_in, -share * v[0], -kMaxUnderlapIn, kMaxUnderlapIn);
     }},
    {24,
     "pilot_spring_weak",
     Part::kRelay,
     {{{"rate_lost", "", 0.0, 0.9, 0.2, "share of the rate of spring (11) that is lost"}}},
     "The relay piston's spring is weak: the same P1 moves the relay piston, and so the piston, farther.",
     [](P& p, const V& v, double share, double) noexcept {
       Lose(p.servo.pilot_spring_rate_lbf_in, share * v[0], kLeastSpringLbfIn);
     }},
    {25,
     "main_spring_weak",
     Part::kRelay,
     {{{"rate_lost", "", 0.0, 0.9, 0.2, "share of the rate of spring (10) that is lost, its preload stays"}}},
     "The plunger's spring is weak: P4 moves the plunger farther.",
     [](P& p, const V& v, double share, double) noexcept {
       Lose(p.servo.main_spring_rate_lbf_in, share * v[0], kLeastSpringLbfIn);
     }},
    {28,
     "pilot_spring_broken",
     Part::kRelay,
     {},
     "The relay piston's spring has broken (1 % of its rate is left): little P1 opens the valve fully.",
     [](P& p, const V&, double share, double) noexcept {
       Lose(p.servo.pilot_spring_rate_lbf_in, share * 0.99, kLeastSpringLbfIn);
     },
     Needs::kFullPhysics},
    {29,
     "main_spring_broken",
     Part::kRelay,
     {},
     "The plunger's spring has broken (1 % of rate and preload is left): the least P4 lifts it, the piston "
     "opens.",
     [](P& p, const V&, double share, double) noexcept {
       Lose(p.servo.main_spring_rate_lbf_in, share * 0.99, kLeastSpringLbfIn);
       Lose(p.servo.main_spring_preload_lbf, share * 0.99, 0.0);
     },
     Needs::kFullPhysics},
    {19,
     "plunger_stuck",
     Part::kRelay,
     {{{"opening_in", "in", -0.25, 0.25, 0.005, "where it sticks: x2 - x4, above 0 towards the supply"}}},
     "The relay plunger sticks in its bushing, at once: the piston runs to a stop at a constant rate, "
     "whatever P1.",
     [](P& p, const V& v, double share, double) noexcept {
       if (share > 0.0) StickPlunger(p, v[0]);
     },
     Needs::kFullPhysics},
    {18,
     "relay_piston_stuck",
     Part::kRelay,
     {{{"x1_in", "in", 0.0, 8.0, 4.2, "where it sticks"}}},
     "The relay piston sticks, at once: P1 moves nothing any more, the piston goes to the position that "
     "belongs to x1 and stays there.",
     [](P& p, const V& v, double share, double) noexcept {
       if (share > 0.0) HoldRelayPiston(p, v[0]);
     },
     Needs::kFullPhysics},
    {26,
     "cam_slipped",
     Part::kRelay,
     {{{"offset_in", "in", -2.0, 2.0, 0.1, "of the bushing, upward"}}},
     "The feedback cam has slipped: the same P1 gives a piston position that is off by the offset over "
     "alpha.",
     [](P& p, const V& v, double share, double) noexcept { MoveCam(p, share * v[0]); }},
    {27,
     "cam_worn",
     Part::kRelay,
     {{{"gain_lost", "", 0.0, 0.9, 0.2, "share of the feedback's slope that is lost"}}},
     "The feedback cam is worn: less feedback, more piston travel for the same P1.",
     [](P& p, const V& v, double share, double) noexcept {
       for (double* alpha : {&p.cam.alpha, &p.cam.lower_alpha, &p.cam.upper_alpha})
         Lose(*alpha, share * v[0], kLeastAlpha);
     }},
});

}  // namespace servohil::fault
