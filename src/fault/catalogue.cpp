#include "servohil/fault/catalogue.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "servohil/model/oil.hpp"

namespace servohil::fault {
namespace {

using P = model::Parameters;
using V = Values;

constexpr ParameterSpec kNone = {nullptr, "", 0.0, 0.0, 0.0, ""};

/// From `is` to `becomes` as far as `share` says; `is` itself, to the last bit, at 0.
double Toward(double is, double becomes, double share) noexcept {
  return is + share * (becomes - is);
}

double Sine(double amplitude, double frequency_hz, double t_s) noexcept {
  return amplitude * std::sin(2.0 * std::numbers::pi * frequency_hz * t_s);
}

// Faults that add up stay within what a configuration may hold (app/key_table.cpp).

/// A passage's area, lost but for a pinhole that the smallest diameter of a configuration has.
void Plug(double& diameter_in, double area_lost) noexcept {
  constexpr double kPinholeIn = 1e-3;
  diameter_in = std::max(std::min(diameter_in, kPinholeIn), diameter_in * std::sqrt(1.0 - area_lost));
}
/// Loses a share of itself, but not all.
void Lose(double& value, double lost, double least) noexcept {
  value = std::max(std::min(value, least), value * (1.0 - lost));
}
void AddTo(double& value, double more, double low, double high) noexcept {
  value = std::clamp(value + more, std::min(value, low), std::max(value, high));
}

constexpr double kLeastSpringLbfIn = 0.1;
constexpr double kMostUnderlapIn = 0.05;
constexpr double kMostClearanceIn = 0.02;
constexpr double kMostPistonClearanceIn = 0.05;
constexpr double kLeastAlpha = 0.01;
constexpr double kLeastPortWidthIn = 0.01;

/// Oil at another temperature: its viscosity and density change as the named oil's do, a custom oil's as
/// those of MIL-H-5606, the thesis' oil.
void SetTemperature(P& p, const V& v, double share, double) noexcept {
  model::OilParameters like = p.oil;
  if (like.name == model::OilName::kCustom) like.name = model::OilName::kMilH5606;
  const model::Oil before = model::OilAt(like);
  like.temperature_c = Toward(like.temperature_c, v[0], share);
  const model::Oil after = model::OilAt(like);
  p.oil.temperature_c = like.temperature_c;
  p.oil.density_lbf_s2_in4 *= after.density_lbf_s2_in4 / before.density_lbf_s2_in4;
  p.oil.viscosity_lbf_s_in2 *= after.viscosity_lbf_s_in2 / before.viscosity_lbf_s_in2;
}

/// Supply pressure, or the pump's set point, not below the drain's. The accumulator keeps its capacity.
void SetSupply(P& p, double psi) noexcept {
  model::SupplyParameters& s = p.supply;
  const double lowest = p.physics == model::Physics::kFull ? s.drain_pressure_psi : 0.0;
  const double to = std::max(lowest, psi);
  s.accumulator_volume_in3 *= (to + model::kAtmospherePsi) / (s.pressure_psi + model::kAtmospherePsi);
  s.pressure_psi = to;
}

/// Gas that is lost takes the pressure along at which the diaphragm meets its seat: P V^k of what is left.
void LoseGas(P& p, double lost) noexcept {
  model::StabilizerParameters& s = p.stabilizer;
  const double left = 1.0 - lost;
  s.gas_volume_in3 *= left;
  s.precharge_psi += (s.precharge_psi + model::kAtmospherePsi) * (std::pow(left, s.polytropic_index) - 1.0);
}

void ForEachLoad(P& p, const auto& change) noexcept {
  p.load.opening = change(p.load.opening);
  if (p.load.has_closing) p.load.closing = change(p.load.closing);
}
void ShiftLoad(P& p, double psi) noexcept {
  ForEachLoad(p, [&](const model::LoadCurve& curve) { return curve.Shifted(psi); });
}

void MoveCam(P& p, double offset_in) noexcept {
  p.cam.x3_star_in += offset_in;
  p.cam.lower_x3_star_in += offset_in;
  p.cam.upper_x3_star_in += offset_in;
}

/// A spring so stiff, and so preloaded, that no pressure moves the plunger from there.
void StickPlunger(P& p, double opening_in) noexcept {
  constexpr double kStuckLbfIn = 1e9;
  const double travel_in = p.servo.relay_plunger_travel_in;
  p.servo.main_spring_rate_lbf_in = kStuckLbfIn;
  p.servo.main_spring_preload_lbf = -kStuckLbfIn * std::clamp(opening_in, -travel_in, travel_in);
}

// Numbers stay for ever: recordings hold them. New faults take new ones. Those that act together act in the
// order of this table, in whichever order they were injected.
constexpr std::array kCatalogue = std::to_array<Spec>({
    {1,
     "air_entrainment",
     Part::kOil,
     {{{"fraction", "", 0.0, 0.2, 0.02, "free air per liquid, both volumes at atmospheric pressure"},
       kNone,
       kNone}},
     "Air comes into the oil: the hydraulic spring softens, most of all at low pressure.",
     [](P& p, const V& v, double share, double) noexcept {
       p.oil.air_fraction = Toward(p.oil.air_fraction, v[0], share);
     },
     true,
     false,
     false},
    {2,
     "bulk_modulus",
     Part::kOil,
     {{{"psi", "psi", 1e3, 5e5, 40'000.0, "bulk modulus of the oil"}, kNone, kNone}},
     "The oil's bulk modulus becomes another one, at all pressures.",
     [](P& p, const V& v, double share, double) noexcept {
       p.servo.bulk_modulus_psi = Toward(p.servo.bulk_modulus_psi, v[0], share);
     },
     false,
     false,
     false},
    {3,
     "cold_oil",
     Part::kOil,
     {{{"temperature_c", "°C", -20.0, 40.0, 10.0, "temperature of the oil"}, kNone, kNone}},
     "The oil is cold and viscous: capillaries and leakages pass less, the piston is damped more.",
     SetTemperature,
     false,
     false,
     false},
    {4,
     "hot_oil",
     Part::kOil,
     {{{"temperature_c", "°C", 40.0, 120.0, 80.0, "temperature of the oil"}, kNone, kNone}},
     "The oil is hot and thin: capillaries and leakages pass more, the piston is damped less.",
     SetTemperature,
     false,
     false,
     false},

    {13,
     "drain_back_pressure",
     Part::kSupply,
     {{{"psi", "psi", 0.0, 100.0, 3.0, "pressure in the drain, gauge"}, kNone, kNone}},
     "The drain backs up: the piston closes more slowly, and above F_s/A2 (nominal: 5.8 psi) not at all: it "
     "opens.",
     [](P& p, const V& v, double share, double) noexcept {
       p.supply.drain_pressure_psi = Toward(p.supply.drain_pressure_psi, v[0], share);
       SetSupply(p, p.supply.pressure_psi);
     },
     true,
     false,
     false},
    {10,
     "supply_sag",
     Part::kSupply,
     {{{"depth_psi", "psi", 0.0, 5000.0, 60.0, "below the supply pressure, at most down to the drain's"},
       kNone,
       kNone}},
     "The supply pressure falls: the piston opens more slowly, its largest force is less.",
     [](P& p, const V& v, double share, double) noexcept {
       SetSupply(p, p.supply.pressure_psi - share * v[0]);
     },
     false,
     false,
     false},
    {11,
     "supply_ripple",
     Part::kSupply,
     {{{"amplitude_psi", "psi", 0.0, 500.0, 10.0, "amplitude of the sine"},
       {"frequency_hz", "Hz", 0.01, 500.0, 25.0, "its frequency"},
       kNone}},
     "The supply pressure (of a finite pump: its set point) oscillates, as a worn pump makes it.",
     [](P& p, const V& v, double share, double t_s) noexcept {
       SetSupply(p, p.supply.pressure_psi + Sine(share * v[0], v[1], t_s));
     },
     false,
     false,
     true},
    {12,
     "supply_loss",
     Part::kSupply,
     {{kNone, kNone, kNone}},
     "The supply pressure falls to the drain's (of a finite pump: it delivers no more): the load closes the "
     "valve.",
     [](P& p, const V&, double share, double) noexcept {
       SetSupply(p, Toward(p.supply.pressure_psi, p.supply.drain_pressure_psi, share));
     },
     true,
     false,
     false},

    {20,
     "capillary_plugged",
     Part::kRelay,
     {{{"area_lost", "", 0.0, 0.99, 0.5, "share of the capillary's area that is lost"}, kNone, kNone}},
     "The capillary through the relay plunger clogs: P4 rises more slowly, the piston opens more slowly.",
     [](P& p, const V& v, double share, double) noexcept {
       Plug(p.servo.capillary_diameter_in, share * v[0]);
     },
     false,
     false,
     false},
    {21,
     "relay_port_silted",
     Part::kRelay,
     {{{"width_lost", "", 0.0, 0.99, 0.5, "share of the relay ports' width that is lost"}, kNone, kNone}},
     "The relay's ports silt up: they must open farther to pass the same flow, P4 falls more slowly.",
     [](P& p, const V& v, double share, double) noexcept {
       Lose(p.servo.relay_port_width_in, share * v[0], kLeastPortWidthIn);
     },
     false,
     false,
     false},
    {22,
     "plunger_worn",
     Part::kRelay,
     {{{"clearance_in", "in", 0.0, 0.01, 0.002, "more radial clearance of the relay plunger"},
       {"underlap_in", "in", 0.0, 0.02, 0.002, "more underlap"},
       kNone}},
     "The relay plunger's edges are worn: more oil leaks at rest, the metering is softer.",
     [](P& p, const V& v, double share, double) noexcept {
       AddTo(p.servo.relay_plunger_clearance_in, share * v[0], 0.0, kMostClearanceIn);
       AddTo(p.servo.underlap_in, share * v[1], -kMostUnderlapIn, kMostUnderlapIn);
     },
     false,
     false,
     false},
    {23,
     "plunger_overlapped",
     Part::kRelay,
     {{{"overlap_in", "in", 0.0, 0.02, 0.004, "less underlap"}, kNone, kNone}},
     "The relay plunger overlaps its ports: a dead band in which the piston is not metered.",
     [](P& p, const V& v, double share, double) noexcept {
       AddTo(p.servo.underlap_in, -share * v[0], -kMostUnderlapIn, kMostUnderlapIn);
     },
     false,
     false,
     false},
    {24,
     "pilot_spring_weak",
     Part::kRelay,
     {{{"rate_lost", "", 0.0, 0.9, 0.2, "share of the rate of spring (11) that is lost"}, kNone, kNone}},
     "The relay piston's spring is weak: the same P1 moves the relay piston, and so the piston, farther.",
     [](P& p, const V& v, double share, double) noexcept {
       Lose(p.servo.pilot_spring_rate_lbf_in, share * v[0], kLeastSpringLbfIn);
     },
     false,
     false,
     false},
    {25,
     "main_spring_weak",
     Part::kRelay,
     {{{"rate_lost", "", 0.0, 0.9, 0.2, "share of the rate of spring (10) that is lost, its preload stays"},
       kNone,
       kNone}},
     "The plunger's spring is weak: P4 moves the plunger farther.",
     [](P& p, const V& v, double share, double) noexcept {
       Lose(p.servo.main_spring_rate_lbf_in, share * v[0], kLeastSpringLbfIn);
     },
     false,
     false,
     false},
    {28,
     "pilot_spring_broken",
     Part::kRelay,
     {{kNone, kNone, kNone}},
     "The relay piston's spring has broken (1 % of its rate is left): little P1 opens the valve fully.",
     [](P& p, const V&, double share, double) noexcept {
       Lose(p.servo.pilot_spring_rate_lbf_in, share * 0.99, kLeastSpringLbfIn);
     },
     true,
     false,
     false},
    {29,
     "main_spring_broken",
     Part::kRelay,
     {{kNone, kNone, kNone}},
     "The plunger's spring has broken (1 % of rate and preload is left): the least P4 lifts it, the piston "
     "opens.",
     [](P& p, const V&, double share, double) noexcept {
       Lose(p.servo.main_spring_rate_lbf_in, share * 0.99, kLeastSpringLbfIn);
       Lose(p.servo.main_spring_preload_lbf, share * 0.99, 0.0);
     },
     true,
     false,
     false},
    {19,
     "plunger_stuck",
     Part::kRelay,
     {{{"opening_in", "in", -0.25, 0.25, 0.005, "where it sticks: x2 - x4, above 0 towards the supply"},
       kNone,
       kNone}},
     "The relay plunger sticks in its bushing, at once: the piston runs to a stop at a constant rate, "
     "whatever P1.",
     [](P& p, const V& v, double share, double) noexcept {
       if (share > 0.0) StickPlunger(p, v[0]);
     },
     true,
     false,
     false},
    {26,
     "cam_slipped",
     Part::kRelay,
     {{{"offset_in", "in", -2.0, 2.0, 0.1, "of the bushing, upward"}, kNone, kNone}},
     "The feedback cam has slipped: the same P1 gives a piston position that is off by the offset over "
     "alpha.",
     [](P& p, const V& v, double share, double) noexcept { MoveCam(p, share * v[0]); },
     false,
     false,
     false},
    {27,
     "cam_worn",
     Part::kRelay,
     {{{"gain_lost", "", 0.0, 0.9, 0.2, "share of the feedback's slope that is lost"}, kNone, kNone}},
     "The feedback cam is worn: less feedback, more piston travel for the same P1.",
     [](P& p, const V& v, double share, double) noexcept {
       for (double* alpha : {&p.cam.alpha, &p.cam.lower_alpha, &p.cam.upper_alpha})
         Lose(*alpha, share * v[0], kLeastAlpha);
     },
     false,
     false,
     false},

    {30,
     "coulomb_friction",
     Part::kPiston,
     {{{"psi", "psi", 0.0, 200.0, 10.0, "Coulomb friction, as a pressure under the piston"}, kNone, kNone}},
     "Dry friction holds the piston until the pressure overcomes it.",
     [](P& p, const V& v, double share, double) noexcept {
       p.friction.coulomb_psi = Toward(p.friction.coulomb_psi, v[0], share);
     },
     false,
     false,
     false},
    {31,
     "stiction",
     Part::kPiston,
     {{{"psi", "psi", 0.0, 400.0, 20.0, "breakaway from rest, as a pressure under the piston"},
       kNone,
       kNone}},
     "The piston sticks at rest and jumps when it breaks away.",
     [](P& p, const V& v, double share, double) noexcept {
       const double is = std::max(p.friction.breakaway_psi, p.friction.coulomb_psi);
       if (share > 0.0) p.friction.breakaway_psi = Toward(is, v[0], share);
     },
     true,
     false,
     false},
    {32,
     "piston_jammed",
     Part::kPiston,
     {{kNone, kNone, kNone}},
     "The piston stops where it is and stays there, whatever the pressures.",
     [](P& p, const V&, double share, double) noexcept {
       constexpr double kMoreThanAnyPressurePsi = 20'000.0;
       p.friction.coulomb_psi = Toward(p.friction.coulomb_psi, kMoreThanAnyPressurePsi, share);
       p.friction.closing_ratio = Toward(p.friction.closing_ratio, 1.0, share);
     },
     false,
     false,
     false},
    {33,
     "piston_leak",
     Part::kPiston,
     {{{"clearance_in", "in", 0.0, 0.02, 0.01, "more clearance of the piston, on diameter"}, kNone, kNone}},
     "Oil leaks past the piston: P3 sinks under load, the plunger must stay open to hold it.",
     [](P& p, const V& v, double share, double) noexcept {
       AddTo(p.servo.piston_clearance_in, share * v[0], 0.0, kMostPistonClearanceIn);
     },
     false,
     false,
     false},

    {40,
     "load_step",
     Part::kLoad,
     {{{"psi", "psi", -300.0, 300.0, 20.0, "more load, as a pressure under the piston"}, kNone, kNone}},
     "The load on the piston changes, at all positions alike.",
     [](P& p, const V& v, double share, double) noexcept { ShiftLoad(p, share * v[0]); },
     false,
     false,
     false},
    {41,
     "load_oscillation",
     Part::kLoad,
     {{{"amplitude_psi", "psi", 0.0, 200.0, 10.0, "amplitude of the sine, as a pressure under the piston"},
       {"frequency_hz", "Hz", 0.01, 500.0, 10.0, "its frequency"},
       kNone}},
     "The load on the piston oscillates, as steam flow in a valve makes it.",
     [](P& p, const V& v, double share, double t_s) noexcept { ShiftLoad(p, Sine(share * v[0], v[1], t_s)); },
     false,
     false,
     true},
    {42,
     "stem_stuck",
     Part::kLoad,
     {{{"from_in", "in", 0.0, 100.0, 3.4, "piston position at which the stem has stuck"},
       {"over_in", "in", 0.25, 100.0, 1.6, "upward from there: over which part"},
       kNone}},
     "A valve's stem is stuck: over a part of the stroke the load stays what it is at the part's beginning.",
     [](P& p, const V& v, double share, double) noexcept {
       ForEachLoad(
           p, [&](const model::LoadCurve& curve) { return curve.HeldBetween(v[0], v[0] + v[1], share); });
     },
     false,
     false,
     false},

    {50,
     "stabilizer_isolated",
     Part::kStabilizer,
     {{kNone, kNone, kNone}},
     "The stabilizer's valve is shut: the servomotor is as without one, P8 stays what it is.",
     [](P& p, const V&, double share, double) noexcept { Plug(p.stabilizer.capillary_diameter_in, share); },
     false,
     true,
     false},
    {51,
     "stabilizer_capillary_plugged",
     Part::kStabilizer,
     {{{"area_lost", "", 0.0, 0.99, 0.5, "share of the capillary's area that is lost"}, kNone, kNone}},
     "The stabilizer's capillary clogs: less oil comes and goes.",
     [](P& p, const V& v, double share, double) noexcept {
       Plug(p.stabilizer.capillary_diameter_in, share * v[0]);
     },
     false,
     true,
     false},
    {52,
     "gas_charge_lost",
     Part::kStabilizer,
     {{{"volume_lost", "", 0.0, 0.99, 0.5, "share of the gas that is lost"}, kNone, kNone}},
     "The stabilizer has lost gas: it takes less oil for the same change of pressure.",
     [](P& p, const V& v, double share, double) noexcept { LoseGas(p, share * v[0]); },
     false,
     true,
     false},
    {53,
     "diaphragm_ruptured",
     Part::kStabilizer,
     {{kNone, kNone, kNone}},
     "The stabilizer's diaphragm has ruptured and 99.9 % of the gas is gone: a volume of oil is left.",
     [](P& p, const V&, double share, double) noexcept { LoseGas(p, share * 0.999); },
     false,
     true,
     false},
});

}  // namespace

const char* NameOf(Part part) noexcept {
  static constexpr std::array kNames = {"oil", "supply", "relay", "piston", "load", "stabilizer"};
  return kNames[static_cast<std::size_t>(part)];
}

std::span<const Spec> Catalogue() noexcept {
  return kCatalogue;
}

const Spec* Find(std::uint8_t id) noexcept {
  const auto* const found =
      std::find_if(kCatalogue.begin(), kCatalogue.end(), [&](const Spec& s) { return s.id == id; });
  return found == kCatalogue.end() ? nullptr : found;
}

const char* Unsupported(const Spec& spec, const model::Parameters& unfaulted) noexcept {
  if (spec.full_only && unfaulted.physics != model::Physics::kFull)
    return "model.physics = \"thesis\" does not have what it acts on";
  if (spec.needs_stabilizer && !unfaulted.stabilizer.enabled) return "stabilizer.enabled is false";
  return nullptr;
}

}  // namespace servohil::fault
