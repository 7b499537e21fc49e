#pragma once
/// Constants computed once from the parameters; never stored in a file. Symbols of the thesis.

#include "servohil/model/cam.hpp"
#include "servohil/model/load_curve.hpp"
#include "servohil/model/parameters.hpp"

namespace servohil::model {

struct Derived {
  explicit Derived(const Parameters& parameters) noexcept;

  // Areas [in²]
  double A1;  ///< relay piston: pi (d2² - d1²) / 4, (2.1)
  double A2;  ///< above the relay plunger
  double A3;  ///< main piston: pi d3² / 4
  // Springs and masses
  double k1;  ///< [lbf/in]
  double k2;  ///< [lbf/in]
  double Fs;  ///< [lbf]
  double M;   ///< m3 + m_e [lbf s²/in], (2.12), (2.13)
  // Orifices: k = c_d pi d sqrt(2/rho) [in² / (s psi^½)], (2.4) to (2.6)
  double k_relay;     ///< orifice 5, width w1
  double k_metering;  ///< orifices 3 and 6, diameter d6
  double cr1;         ///< [in]
  double cr2;         ///< [in]
  double U;           ///< [in]
  // Laminar passages
  double capillary_a;  ///< 128 mu L4 / (pi d4⁴) [lbf s/in⁵], (2.3)
  double capillary_b;  ///< 2.28 rho / (16 pi mu L4) [s/in³], (2.3)
  double c3;  ///< leakage past the piston: pi d3 (c_r3/2)³ / (12 mu L3) [in⁵/(lbf s)], (2.8), errata 3
  double C;   ///< viscous damping: mu L3 pi d3 / (c_r3/2) [lbf s/in], Appendix E, errata 4
  // Volumes and compliance
  double beta;              ///< [psi]
  double V3_at_zero;        ///< [in³]
  double relay_compliance;  ///< V4/beta + A2²/k2 [in⁵/lbf], P(21) of Appendix E
  // Pressures and forces
  double P2;         ///< supply [psi]
  double F_coulomb;  ///< B A3 [lbf], (4.4)
  // Stabilizer, (5.2), (5.7)
  bool stabilizer;
  double G7;            ///< pi d7⁴ / (128 mu L7) [in⁵/(lbf s)]; 0 where there is none
  double V8_over_beta;  ///< [in⁵/lbf]
  double Va_over_k;     ///< V_a / k [in³]

  double stroke_in;
  Cam cam;
  LoadCurve load;
};

}  // namespace servohil::model
