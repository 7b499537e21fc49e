#pragma once
/// The oil: bulk modulus with entrained air and vapour, viscosity and density over temperature. MODEL.md.

#include <cmath>

#include "servohil/model/parameters.hpp"

namespace servohil::model {

inline constexpr double kAtmospherePsi = 14.696;  ///< standard atmosphere, absolute

/// Effective bulk modulus of liquid, free gas and vapour as a function of pressure:
///   V_g(P) = r' theta(P) ((p_atm - p_v)/(P_abs - p_v))^(1/n)     gas per volume of liquid
///   K(P)   = (1 + V_g) / (1/K_l - dV_g/dP)
/// Merritt, Hydraulic Control Systems (1967), section 2.3; Gholizadeh, Burton, Schoenau, Int. J. Fluid Power 13
/// (2012). K -> 0 as P_abs -> p_v: no chamber falls below vapour pressure. K -> K_l without gas.
class BulkModulus {
 public:
  BulkModulus(const OilParameters& oil, double liquid_modulus_psi) noexcept;

  /// K [psi > 0] at P [psi gauge]. Real-time safe.
  double At(double p_psi) const noexcept;

  /// Lowest pressure there can be, exclusive [psi gauge].
  double LowestPsi() const noexcept { return vapour_psi_ - kAtmospherePsi; }

 private:
  double inverse_liquid_;
  double air_;
  double inverse_index_;
  bool isothermal_;
  double vapour_psi_;
  double inverse_dissolution_span_;  ///< 1/(p_d - p_atm); 0 where nothing dissolves
};

struct Oil {
  double density_lbf_s2_in4;
  double viscosity_lbf_s_in2;
};

/// Density and viscosity of the configured oil, from its data at its temperature unless it is "custom":
///   log10 log10(nu + 0.7) = A - B log10 T        Walther, ASTM D341; nu [cSt], T [K]
///   rho = rho15 (1 - 7e-4 (T - 15 °C))
/// Validity: -20 to 120 °C.
Oil OilAt(const OilParameters& oil) noexcept;

}  // namespace servohil::model
