#pragma once
/// Faults of the oil and of its supply.
/// A part of the catalogue's table: read by catalogue.cpp alone.

#include "fault/parameter_acts.hpp"
#include "model/oil.hpp"

namespace servohil::fault {

/// Oil at another temperature: its viscosity and density change as the named oil's do, a custom oil's as
/// those of MIL-H-5606, the thesis' oil.
inline void SetTemperature(P& p, const V& v, double share, double) noexcept {
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
inline void SetSupply(P& p, double psi) noexcept {
  model::SupplyParameters& s = p.supply;
  const double lowest = p.physics == model::Physics::kFull ? s.drain_pressure_psi : 0.0;
  const double to = std::max(lowest, psi);
  s.accumulator_volume_in3 *= (to + model::kAtmospherePsi) / (s.pressure_psi + model::kAtmospherePsi);
  s.pressure_psi = to;
}

inline constexpr std::array kOilAndSupplyFaults = std::to_array<Spec>({
    {1,
     "air_entrainment",
     Part::kOil,
     {{{"fraction", "", 0.0, 0.2, 0.02, "free air per liquid, both volumes at atmospheric pressure"}}},
     "Air comes into the oil: the hydraulic spring softens, most of all at low pressure.",
     [](P& p, const V& v, double share, double) noexcept {
       p.oil.air_fraction = Toward(p.oil.air_fraction, v[0], share);
     },
     Needs::kFullPhysics},
    {2,
     "bulk_modulus",
     Part::kOil,
     {{{"psi", "psi", 1e3, 5e5, 40'000.0, "bulk modulus of the oil"}}},
     "The oil's bulk modulus becomes another one, at all pressures.",
     [](P& p, const V& v, double share, double) noexcept {
       p.servo.bulk_modulus_psi = Toward(p.servo.bulk_modulus_psi, v[0], share);
     }},
    {3,
     "cold_oil",
     Part::kOil,
     {{{"temperature_c", "°C", -20.0, 40.0, 10.0, "temperature of the oil"}}},
     "The oil is cold and viscous: capillaries and leakages pass less, the piston is damped more.",
     SetTemperature},
    {4,
     "hot_oil",
     Part::kOil,
     {{{"temperature_c", "°C", 40.0, 120.0, 80.0, "temperature of the oil"}}},
     "The oil is hot and thin: capillaries and leakages pass more, the piston is damped less.",
     SetTemperature},
    {13,
     "drain_back_pressure",
     Part::kSupply,
     {{{"psi", "psi", 0.0, 100.0, 3.0, "pressure in the drain, gauge"}}},
     "The drain backs up: the piston closes more slowly, and above F_s/A2 (nominal: 5.8 psi) not at all: it "
     "opens.",
     [](P& p, const V& v, double share, double) noexcept {
       p.supply.drain_pressure_psi = Toward(p.supply.drain_pressure_psi, v[0], share);
       SetSupply(p, p.supply.pressure_psi);
     },
     Needs::kFullPhysics},
    {10,
     "supply_sag",
     Part::kSupply,
     {{{"depth_psi", "psi", 0.0, 5000.0, 60.0, "below the supply pressure, at most down to the drain's"}}},
     "The supply pressure falls: the piston opens more slowly, its largest force is less.",
     [](P& p, const V& v, double share, double) noexcept {
       SetSupply(p, p.supply.pressure_psi - share * v[0]);
     }},
    {11,
     "supply_ripple",
     Part::kSupply,
     {{{"amplitude_psi", "psi", 0.0, 500.0, 10.0, "amplitude of the sine"},
       {"frequency_hz", "Hz", 0.01, 500.0, 25.0, "its frequency"}}},
     "The supply pressure (of a finite pump: its set point) oscillates, as a worn pump makes it.",
     [](P& p, const V& v, double share, double t_s) noexcept {
       SetSupply(p, p.supply.pressure_psi + Sine(share * v[0], v[1], t_s));
     },
     Needs::kNothing,
     true},
    {12,
     "supply_loss",
     Part::kSupply,
     {},
     "The supply pressure falls to the drain's (of a finite pump: it delivers no more): the load closes the "
     "valve.",
     [](P& p, const V&, double share, double) noexcept {
       SetSupply(p, Toward(p.supply.pressure_psi, p.supply.drain_pressure_psi, share));
     },
     Needs::kFullPhysics},
});

}  // namespace servohil::fault
