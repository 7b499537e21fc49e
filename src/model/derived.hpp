#pragma once
/// Constants computed once from the parameters; never stored in a file. Symbols of the thesis.

#include "model/cam.hpp"
#include "model/fixed_power.hpp"
#include "model/load_curve.hpp"
#include "model/oil.hpp"
#include "model/parameters.hpp"

namespace servohil::model {

struct Derived {
  explicit Derived(const Parameters& parameters) noexcept;

  bool full;  ///< physics "full"; else the thesis' equations to the letter

  // Areas [in²]
  double A1;  ///< relay piston: pi (d2² - d1²) / 4, (2.1)
  double A2;  ///< above the relay plunger
  double A3;  ///< main piston: pi d3² / 4
  // Springs and masses
  double k1;               ///< [lbf/in]
  double k2;               ///< [lbf/in]
  double Fs;               ///< [lbf]
  double M;                ///< m3 + m_e [lbf s²/in], (2.12), (2.13)
  double x1_per_psi;       ///< A1/k1 [in/psi], (2.1)
  double plunger_per_psi;  ///< A2/k2 [in/psi], (2.2)
  double plunger_at_zero;  ///< x2 - x4 at P4 = 0: -F_s/k2 [in], (2.2)
  // Orifices: k = c_d pi d sqrt(2/rho) [in² / (s psi^½)], (2.4) to (2.6)
  double k_relay;     ///< orifice 5, width w1
  double k_metering;  ///< orifices 3 and 6, diameter d6
  double cr1;         ///< [in]
  double cr2;         ///< [in]
  double U;           ///< [in]
  double h_relay;     ///< port heights [in]; infinite in the thesis
  double h_metering;
  double p_transition;  ///< p_t [psi]
  // Laminar passages
  double capillary_a;  ///< 128 mu L4 / (pi d4⁴) [lbf s/in⁵], (2.3)
  double capillary_b;  ///< 2.28 rho / (16 pi mu L4) [s/in³], (2.3)
  double c3;  ///< leakage past the piston: pi d3 (c_r3/2)³ / (12 mu L3) [in⁵/(lbf s)], (2.8), errata 3
  double C;   ///< viscous damping: mu L3 pi d3 / (c_r3/2) [lbf s/in], Appendix E, errata 4
  // Oil, volumes and compliance
  double beta;               ///< thesis: K [psi]
  OilModulus oil;            ///< full: K(P)
  double V3_at_zero;         ///< [in³]
  double V4;                 ///< [in³]
  double spring_compliance;  ///< A2²/k2 [in⁵/lbf], of the chamber above the plunger
  // Stops
  double x1_low;           ///< [in]; minus infinity in the thesis
  double x1_stop;          ///< [in]; infinite in the thesis, as the following
  double plunger_low_psi;  ///< P4 at which the plunger meets its stops
  double plunger_high_psi;
  double plunger_travel;  ///< [in]
  double x3_low;          ///< end stops of the piston [in]
  double x3_high;
  double stroke_in;
  // Supply
  double P2;            ///< set point or constant [psi]
  double Pe;            ///< drain [psi]
  double pump_flow;     ///< [in³/s]; 0: P2 is constant
  double inverse_band;  ///< [1/psi]
  double C2;            ///< accumulator [in⁵/lbf]
  // Friction [lbf]
  bool directional;         ///< friction or two load curves: the piston can be stuck
  double F_coulomb;         ///< B A3, (4.4)
  double F_breakaway;       ///< B_s A3
  double inverse_stribeck;  ///< 1/v_s [s/in]
  double C_viscous;         ///< B_v A3 [lbf s/in]
  double closing_ratio;
  // Stabilizer, (5.2), (5.7)
  bool stabilizer;
  double R7;  ///< 128 mu L7 / (pi d7⁴) [lbf s/in⁵]
  double b7;  ///< end losses, as capillary_b [s/in³]; 0 in the thesis
  double V8;  ///< [in³]
  double Va;  ///< [in³] at the charge pressure
  double k_gas;
  double gas_capacity;   ///< V_a P_charge_abs^(1/k) / k: V_gas/(k P8) = gas_capacity gas_power(P8_abs)
  FixedPower gas_power;  ///< of -1 - 1/k
  double precharge;      ///< [psi gauge]; minus infinity in the thesis

  Cam cam;
  LoadCurve load_up;  ///< for a rising piston and, with one curve, for both
  LoadCurve load_down;
};

}  // namespace servohil::model
