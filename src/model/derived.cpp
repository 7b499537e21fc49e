#include "servohil/model/derived.hpp"

#include <cmath>
#include <numbers>

namespace servohil::model {
namespace {

using std::numbers::pi;

double Fourth(double d) {
  return d * d * d * d;
}

}  // namespace

Derived::Derived(const Parameters& p) noexcept
    : A1(pi / 4.0 *
         (p.servo.relay_piston_diameter_in * p.servo.relay_piston_diameter_in -
          p.servo.relay_piston_rod_diameter_in * p.servo.relay_piston_rod_diameter_in)),
      A2(p.servo.relay_plunger_area_in2),
      A3(pi / 4.0 * p.servo.piston_diameter_in * p.servo.piston_diameter_in),
      k1(p.servo.pilot_spring_rate_lbf_in),
      k2(p.servo.main_spring_rate_lbf_in),
      Fs(p.servo.main_spring_preload_lbf),
      M(p.servo.piston_mass_lbf_s2_in + p.servo.load_mass_lbf_s2_in),
      k_relay(p.servo.discharge_coefficient * pi * p.servo.relay_port_width_in *
              std::sqrt(2.0 / p.oil.density_lbf_s2_in4)),
      k_metering(p.servo.discharge_coefficient * pi * p.servo.relay_plunger_diameter_in *
                 std::sqrt(2.0 / p.oil.density_lbf_s2_in4)),
      cr1(p.servo.relay_piston_clearance_in),
      cr2(p.servo.relay_plunger_clearance_in),
      U(p.servo.underlap_in),
      capillary_a(128.0 * p.oil.viscosity_lbf_s_in2 * p.servo.capillary_length_in /
                  (pi * Fourth(p.servo.capillary_diameter_in))),
      capillary_b(2.28 * p.oil.density_lbf_s2_in4 /
                  (16.0 * pi * p.oil.viscosity_lbf_s_in2 * p.servo.capillary_length_in)),
      c3(pi * p.servo.piston_diameter_in * std::pow(p.servo.piston_clearance_in / 2.0, 3) /
         (12.0 * p.oil.viscosity_lbf_s_in2 * p.servo.piston_leakage_length_in)),
      C(p.oil.viscosity_lbf_s_in2 * p.servo.piston_leakage_length_in * pi * p.servo.piston_diameter_in /
        (p.servo.piston_clearance_in / 2.0)),
      beta(p.servo.bulk_modulus_psi),
      V3_at_zero(p.servo.piston_volume_at_zero_in3),
      relay_compliance(p.servo.relay_volume_in3 / p.servo.bulk_modulus_psi +
                       p.servo.relay_plunger_area_in2 * p.servo.relay_plunger_area_in2 /
                           p.servo.main_spring_rate_lbf_in),
      P2(p.supply.pressure_psi),
      F_coulomb(p.friction.coulomb_psi * A3),
      stabilizer(p.stabilizer.enabled),
      G7(p.stabilizer.enabled ? pi * Fourth(p.stabilizer.capillary_diameter_in) /
                                    (128.0 * p.oil.viscosity_lbf_s_in2 * p.stabilizer.capillary_length_in)
                              : 0.0),
      V8_over_beta(p.stabilizer.oil_volume_in3 / p.servo.bulk_modulus_psi),
      Va_over_k(p.stabilizer.gas_volume_in3 / p.stabilizer.polytropic_index),
      stroke_in(p.servo.stroke_in),
      cam(p.cam),
      load(p.load) {}

}  // namespace servohil::model
