#pragma once
/// Faults of the sensors: between the truth and the frames, never on the truth.
/// A part of the catalogue's table: read by catalogue.cpp alone.

#include <cmath>
#include <limits>

#include "fault/parameter_acts.hpp"

namespace servohil::fault {

inline constexpr double kNotAvailable = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kFullScale = std::numeric_limits<double>::infinity();
inline constexpr double kMaxOfAnyUnit = 1e6;
inline constexpr double kMaxDelayS = 1.0;  ///< Sensors remember as much

// In the order of what a signal passes: the line to the transducer, the transducer, its output.
inline constexpr std::array kSensorFaults = std::to_array<Spec>({
    {kSensorDelayed,
     "sensor_delayed",
     Part::kSensors,
     {{{"delay_s", "s", 1e-4, kMaxDelayS, 0.05, "between truth and signal"}}},
     "The signal is late: what was true when the fault began is held for the delay, then all follows by it.",
     [](Reading& r, const V&, double, Random&) noexcept { r.value = r.delayed; }},
    {61,
     "sensor_gain",
     Part::kSensors,
     {{{"factor", "", -100.0, 100.0, 1.1, "by which the signal is multiplied"}}},
     "The transducer's gain is wrong.",
     [](Reading& r, const V& v, double share, Random&) noexcept { r.value *= Toward(1.0, v[0], share); }},
    {62,
     "sensor_offset",
     Part::kSensors,
     {{{"by", "of the signal", -kMaxOfAnyUnit, kMaxOfAnyUnit, 0.1, "added to the signal"}}},
     "The transducer's zero is wrong.",
     [](Reading& r, const V& v, double share, Random&) noexcept { r.value += share * v[0]; }},
    {63,
     "sensor_drift",
     Part::kSensors,
     {{{"per_s", "of the signal/s", -kMaxOfAnyUnit, kMaxOfAnyUnit, 0.01, "by which the signal drifts away"}}},
     "The transducer drifts: its error grows with time.",
     [](Reading& r, const V& v, double share, Random&) noexcept { r.value += share * v[0] * r.t_s; }},
    {64,
     "sensor_noise",
     Part::kSensors,
     {{{"deviation", "of the signal", 0.0, kMaxOfAnyUnit, 0.01, "standard deviation of the noise"}}},
     "The signal is noisy: white and Gaussian, another value at each publication.",
     [](Reading& r, const V& v, double share, Random& random) noexcept {
       r.value += share * v[0] * random.Normal();
     },
     Needs::kNothing,
     false,
     true},
    {65,
     "sensor_quantised",
     Part::kSensors,
     {{{"step", "of the signal", 0.0, kMaxOfAnyUnit, 0.05, "between neighbouring values"}}},
     "The signal is coarse: it comes in steps.",
     [](Reading& r, const V& v, double, Random&) noexcept {
       if (v[0] > 0.0) r.value = std::round(r.value / v[0]) * v[0];
     }},
    {66,
     "sensor_frozen",
     Part::kSensors,
     {},
     "The signal stays what it was when the fault began.",
     [](Reading& r, const V&, double, Random&) noexcept { r.value = r.held; }},
    {67,
     "sensor_zero",
     Part::kSensors,
     {},
     "The signal says 0, or the nearest that it can.",
     [](Reading& r, const V&, double share, Random&) noexcept { r.value = Toward(r.value, 0.0, share); }},
    {68,
     "sensor_full_scale",
     Part::kSensors,
     {},
     "The signal is at the upper end of its range, at once.",
     [](Reading& r, const V&, double, Random&) noexcept { r.value = kFullScale; }},
    {69,
     "sensor_open_wire",
     Part::kSensors,
     {},
     "The wire is open, at once: all bits of the signal's field are 1, signal not available.",
     [](Reading& r, const V&, double, Random&) noexcept { r.value = kNotAvailable; }},
    {70,
     "sensor_intermittent",
     Part::kSensors,
     {{{"probability", "", 0.0, 1.0, 0.1, "of each publication to be hit"},
       {"to_zero", "", 0.0, 1.0, 0.0, "0: hit is an open wire; 1: the signal says 0"}}},
     "A loose contact: now and then, at random, the signal is gone.",
     [](Reading& r, const V& v, double share, Random& random) noexcept {
       if (random.Chance(share * v[0])) r.value = v[1] >= 0.5 ? 0.0 : kNotAvailable;
     },
     Needs::kNothing,
     false,
     true},
});

}  // namespace servohil::fault
