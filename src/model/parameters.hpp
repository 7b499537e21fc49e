#pragma once
/// What the user sets: the servomotor and its surroundings, in the units of the source (in, lbf, s, psi
/// gauge). Defaults are Table II of the thesis with the corrections of its errata. Ranges, and how to measure
/// each on a real servomotor, stand with the keys in config/servohil.toml.

#include <cstdint>

#include "model/load_curve.hpp"

namespace servohil::model {

/// "thesis": the source's equations to the letter. "full": what holds over the whole envelope (MODEL.md).
enum class Physics : std::uint8_t { kThesis, kFull };

/// Custom: density and viscosity as given; else from the oil's data at its temperature (oil.hpp).
enum class OilName : std::uint8_t { kCustom, kMilH5606, kIsoVg32 };

struct OilParameters {
  OilName name = OilName::kCustom;
  double temperature_c = 40.0;            ///< named oils only
  double density_lbf_s2_in4 = 8.0e-5;     ///< rho, MIL-H-5606 (Appendix A)
  double viscosity_lbf_s_in2 = 2.2e-6;    ///< mu, MIL-H-5606 at operating temperature (Appendix A)
  double air_fraction = 0.0;              ///< r: free gas per liquid, both volumes at atmospheric pressure
  double air_polytropic_index = 1.0;      ///< n: 1 isothermal, 1.4 adiabatic
  double dissolution_pressure_psi = 0.0;  ///< p_d, absolute: all air dissolved from there on; 0: never
  double vapour_pressure_psi = 0.05;      ///< p_v, absolute
};

struct OrificeParameters {
  double transition_pressure_psi = 0.1;  ///< p_t: laminar below, turbulent above
};

struct ServoParameters {
  double relay_piston_rod_diameter_in = 0.996;  ///< d1
  double relay_piston_diameter_in = 2.494;      ///< d2
  double piston_diameter_in = 9.99;             ///< d3
  double capillary_diameter_in = 0.1875;        ///< d4
  double relay_plunger_diameter_in = 3.495;     ///< d6
  double relay_port_width_in = 1.750;           ///< w1
  double relay_plunger_area_in2 = 2.341;        ///< A2 (Table II's 2.314 is a misprint)
  double relay_piston_clearance_in = 0.002;     ///< c_r1, radial
  double relay_plunger_clearance_in = 0.002;    ///< c_r2, radial
  double piston_clearance_in = 0.001;           ///< c_r3, on diameter (Table II's 0.002 is not what was used)
  double piston_leakage_length_in = 0.8;        ///< L3
  double capillary_length_in = 4.0;             ///< L4
  double pilot_spring_rate_lbf_in = 30.0;       ///< k1, spring (11)
  double main_spring_rate_lbf_in = 212.0;       ///< k2, spring (10)
  double main_spring_preload_lbf = 13.5;        ///< F_s
  double underlap_in = 0.002;                   ///< U
  double piston_mass_lbf_s2_in = 0.303;         ///< m3
  double load_mass_lbf_s2_in = 1.3656;          ///< m_e, lever and valves
  double relay_volume_in3 = 11.6;               ///< V4, above the relay plunger
  double piston_volume_at_zero_in3 = 30.0;      ///< V3 at x3 = 0
  double bulk_modulus_psi = 110'000.0;          ///< beta
  double discharge_coefficient = 0.625;         ///< c_d
  double stroke_in = 8.0;                       ///< largest x3, an end stop
  double relay_port_height_in = 0.25;           ///< largest opening of orifice 5
  double metering_port_height_in = 0.25;        ///< largest opening of orifices 3 and 6
  double relay_piston_stroke_in = 8.0;          ///< largest x1
  double relay_piston_lowest_in = 0.0;          ///< least x1: a fault's, no key
  double relay_plunger_travel_in = 0.25;        ///< largest |x2 - x4|
};

struct SupplyParameters {
  double pressure_psi = 300.0;            ///< P2, or the pump's set point
  double drain_pressure_psi = 0.0;        ///< Pe
  double pump_flow_in3_s = 0.0;           ///< largest; 0: P2 is constant whatever is drawn
  double pump_band_psi = 10.0;            ///< below the set point, over which the pump goes from none to all
  double accumulator_volume_in3 = 500.0;  ///< gas at the set point
};

enum class CamShape : std::uint8_t { kSingle, kTwoSlope };

/// Feedback x4 = alpha x3 + x3*, (2.15). The two-slope cam (Figure 4, curve A) changes its line where they
/// meet.
struct CamParameters {
  CamShape shape = CamShape::kSingle;
  double alpha = 0.32;
  double x3_star_in = 2.90;
  double lower_alpha = 0.90;
  double lower_x3_star_in = 2.10;
  double upper_alpha = 0.45;
  double upper_x3_star_in = 3.38;
};

struct FrictionParameters {
  double coulomb_psi = 0.0;             ///< B (4.4), as a pressure under the piston
  double breakaway_psi = 0.0;           ///< B_s, at least B; 0: as B
  double stribeck_velocity_in_s = 0.1;  ///< v_s, at which half of B_s - B is gone
  double viscous_psi_s_in = 0.0;        ///< B_v
  double closing_ratio = 1.0;           ///< friction downward to friction upward
};

/// Transient flow stabilizer, chapter V.
struct StabilizerParameters {
  bool enabled = false;
  double capillary_diameter_in = 0.30;  ///< d7
  double capillary_length_in = 15.0;    ///< L7
  double oil_volume_in3 = 100.0;        ///< V8
  double gas_volume_in3 = 100.0;        ///< V_a
  double polytropic_index = 1.4;        ///< k
  double charge_pressure_psi = 103.0;   ///< at which the gas has V_a
  double precharge_psi = 20.0;          ///< below it the diaphragm rests on its seat
};

enum class LoadBeyond : std::uint8_t { kExtrapolate, kHold };

/// Load at rest over x3; a second curve for downward motion makes a hysteresis.
struct LoadParameters {
  LoadCurve opening;
  LoadCurve closing;  ///< used where has_closing: nowhere above `opening`
  bool has_closing = false;
  LoadBeyond beyond = LoadBeyond::kExtrapolate;
};

struct Parameters {
  Physics physics = Physics::kFull;
  OilParameters oil;
  OrificeParameters orifice;
  ServoParameters servo;
  SupplyParameters supply;
  CamParameters cam;
  FrictionParameters friction;
  StabilizerParameters stabilizer;
  LoadParameters load;
};

}  // namespace servohil::model
