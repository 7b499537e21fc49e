#include "model/derived.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace servohil::model {
namespace {

using std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kAirIndex = 1.4;

double Fourth(double d) {
  return d * d * d * d;
}

LoadCurve Beyond(const LoadCurve& curve, LoadBeyond beyond, bool full) noexcept {
  return full && beyond == LoadBeyond::kHold ? curve.Held() : curve;
}

}  // namespace

Derived::Derived(const Parameters& p) noexcept
    : full(p.physics == Physics::kFull),
      oil(p.oil, p.servo.bulk_modulus_psi),
      gas_power(-1.0 - 1.0 / p.stabilizer.polytropic_index),
      cam(p.cam) {
  const ServoParameters& s = p.servo;
  const Oil fluid = full ? OilAt(p.oil) : Oil{p.oil.density_lbf_s2_in4, p.oil.viscosity_lbf_s_in2};
  const double rho = fluid.density_lbf_s2_in4;
  const double mu = fluid.viscosity_lbf_s_in2;

  A1 = pi / 4.0 *
       (s.relay_piston_diameter_in * s.relay_piston_diameter_in -
        s.relay_piston_rod_diameter_in * s.relay_piston_rod_diameter_in);
  A2 = s.relay_plunger_area_in2;
  A3 = pi / 4.0 * s.piston_diameter_in * s.piston_diameter_in;
  k1 = s.pilot_spring_rate_lbf_in;
  k2 = s.main_spring_rate_lbf_in;
  Fs = s.main_spring_preload_lbf;
  M = s.piston_mass_lbf_s2_in + s.load_mass_lbf_s2_in;
  x1_per_psi = A1 / k1;
  plunger_per_psi = A2 / k2;
  plunger_at_zero = -Fs / k2;

  const double sharp_edge = s.discharge_coefficient * pi * std::sqrt(2.0 / rho);
  k_relay = sharp_edge * s.relay_port_width_in;
  k_metering = sharp_edge * s.relay_plunger_diameter_in;
  cr1 = s.relay_piston_clearance_in;
  cr2 = s.relay_plunger_clearance_in;
  U = s.underlap_in;
  h_relay = full ? s.relay_port_height_in : kInfinity;
  h_metering = full ? s.metering_port_height_in : kInfinity;
  p_transition = p.orifice.transition_pressure_psi;

  capillary_a = 128.0 * mu * s.capillary_length_in / (pi * Fourth(s.capillary_diameter_in));
  capillary_b = 2.28 * rho / (16.0 * pi * mu * s.capillary_length_in);
  const double gap = s.piston_clearance_in / 2.0;
  c3 = pi * s.piston_diameter_in * gap * gap * gap / (12.0 * mu * s.piston_leakage_length_in);
  C = mu * s.piston_leakage_length_in * pi * s.piston_diameter_in / gap;

  beta = s.bulk_modulus_psi;
  V3_at_zero = s.piston_volume_at_zero_in3;
  V4 = s.relay_volume_in3;
  spring_compliance = A2 * A2 / k2;

  x1_low = full ? s.relay_piston_lowest_in : -kInfinity;
  x1_stop = full ? s.relay_piston_stroke_in : kInfinity;
  plunger_travel = s.relay_plunger_travel_in;
  plunger_low_psi = full ? (Fs - k2 * plunger_travel) / A2 : -kInfinity;
  plunger_high_psi = full ? (Fs + k2 * plunger_travel) / A2 : kInfinity;
  stroke_in = s.stroke_in;
  x3_low = full ? 0.0 : -kInfinity;
  x3_high = full ? stroke_in : kInfinity;

  P2 = p.supply.pressure_psi;
  Pe = full ? p.supply.drain_pressure_psi : 0.0;
  pump_flow = full ? p.supply.pump_flow_in3_s : 0.0;
  inverse_band = 1.0 / p.supply.pump_band_psi;
  C2 = p.supply.accumulator_volume_in3 / (kAirIndex * (P2 + kAtmospherePsi));

  F_coulomb = p.friction.coulomb_psi * A3;
  F_breakaway = full ? std::max(F_coulomb, p.friction.breakaway_psi * A3) : F_coulomb;
  inverse_stribeck = full ? 1.0 / p.friction.stribeck_velocity_in_s : 0.0;
  C_viscous = full ? p.friction.viscous_psi_s_in * A3 : 0.0;
  closing_ratio = full ? p.friction.closing_ratio : 1.0;
  directional = F_breakaway > 0.0 || (full && p.load.has_closing);

  stabilizer = p.stabilizer.enabled;
  R7 = 128.0 * mu * p.stabilizer.capillary_length_in / (pi * Fourth(p.stabilizer.capillary_diameter_in));
  b7 = full ? 2.28 * rho / (16.0 * pi * mu * p.stabilizer.capillary_length_in) : 0.0;
  V8 = p.stabilizer.oil_volume_in3;
  Va = p.stabilizer.gas_volume_in3;
  k_gas = p.stabilizer.polytropic_index;
  gas_capacity = Va / k_gas * std::pow(p.stabilizer.charge_pressure_psi + kAtmospherePsi, 1.0 / k_gas);
  precharge = full ? p.stabilizer.precharge_psi : -kInfinity;

  load_up = Beyond(p.load.opening, p.load.beyond, full);
  load_down = full && p.load.has_closing ? Beyond(p.load.closing, p.load.beyond, full) : load_up;
}

}  // namespace servohil::model
