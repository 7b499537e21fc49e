#pragma once
/// The oil: bulk modulus with entrained air and vapour, viscosity and density over temperature. MODEL.md.

#include <cmath>

#include "model/fixed_power.hpp"
#include "model/parameters.hpp"

namespace servohil::model {

inline constexpr double kAtmospherePsi = 14.696;  ///< standard atmosphere, absolute

/// Effective bulk modulus of liquid, free gas and vapour as a function of pressure:
///   V_g(P) = r' theta(P) ((p_atm - p_v)/(P_abs - p_v))^(1/n)     gas per volume of liquid
///   K(P)   = (1 + V_g) / (1/K_l - dV_g/dP)
/// Merritt, Hydraulic Control Systems (1967), section 2.3; Gholizadeh, Burton, Schoenau, Int. J. Fluid Power
/// 13 (2012). K -> 0 as P_abs -> p_v: no chamber falls below vapour pressure. K -> K_l without gas.
class OilModulus {
 public:
  OilModulus(const OilParameters& oil, double liquid_modulus_psi) noexcept;

  /// 1/K as a fraction, both parts above 0: what divides by a compliance divides once.
  struct Fraction {
    double numerator;
    double denominator;
  };

  /// 1/K [1/psi > 0] at P [psi gauge]. Real-time safe.
  double Compressibility(double p_psi) const noexcept {
    const Fraction f = CompressibilityFraction(p_psi);
    return f.numerator / f.denominator;
  }
  Fraction CompressibilityFraction(double p_psi) const noexcept {
    const double gap = p_psi + kAtmospherePsi - vapour_psi_;
    // Where a stage of the integrator looks below vapour pressure, 1/K is that of this distance above it.
    constexpr double kSmallestGapPsi = 1.0e-6;
    const double held = gap < kSmallestGapPsi ? kSmallestGapPsi : gap;  // a NaN stays one
    if (!only_nuclei_) return WithAir(p_psi, 1.0 / held);
    // V_g = c/gap, -dV_g/dP = c/gap²; both parts times gap².
    const double c = kNuclei * (kAtmospherePsi - vapour_psi_);
    return {inverse_liquid_ * held * held + c, held * (held + c)};
  }

  /// Bound of |d ln K/dP| [1/psi]: over which pressure the stiffness changes, 1/(P - p_v), and below the
  /// dissolution pressure 1/(p_d - P) down to where the liquid is softer than the rest of the air. Real-time
  /// safe.
  double StiffnessChange(double p_psi) const noexcept {
    const double above_vapour = 1.0 / (p_psi - LowestPsi());
    if (inverse_dissolution_span_ == 0.0 || air_ == 0.0) return above_vapour;
    const double below_dissolution = 1.0 / inverse_dissolution_span_ - p_psi;
    if (below_dissolution < -dissolution_edge_psi_) return above_vapour;
    return above_vapour + 1.0 / std::fmax(below_dissolution, dissolution_edge_psi_);
  }

  /// Lowest pressure there can be, exclusive [psi gauge].
  double LowestPsi() const noexcept { return vapour_psi_ - kAtmospherePsi; }

 private:
  /// Gas that no oil is without, per liquid at atmospheric pressure, isothermal: what a cavity opens from.
  /// Its effect on K is below 1 % at atmospheric pressure and 0.1 % from 20 psi gauge on (nominal oil).
  static constexpr double kNuclei = 1.0e-6;

  Fraction WithAir(double p_psi, double inverse_gap) const noexcept;

  double inverse_liquid_;
  double air_;
  double inverse_index_;
  FixedPower expansion_;  ///< ratio^(1/n)
  bool only_nuclei_;
  double vapour_psi_;
  double inverse_dissolution_span_;    ///< 1/(p_d - p_atm); 0 where nothing dissolves
  double dissolution_edge_psi_ = 0.0;  ///< below p_d, where the rest of the air is as soft as the liquid
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
