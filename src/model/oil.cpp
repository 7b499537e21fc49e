#include "model/oil.hpp"

namespace servohil::model {
namespace {

struct OilData {
  double nu40_cst;
  double nu100_cst;
  double density15_kg_m3;
};

OilData DataOf(OilName name) noexcept {
  if (name == OilName::kMilH5606) return {13.2, 4.9, 866.0};  // MIL-PRF-5606H: minima at 40 and 100 °C
  return {32.0, 5.4, 865.0};                                  // ISO 3448 VG 32; typical turbine oil
}

}  // namespace

OilModulus::OilModulus(const OilParameters& oil, double liquid_modulus_psi) noexcept
    : inverse_liquid_(1.0 / liquid_modulus_psi),
      air_(oil.air_fraction),
      inverse_index_(1.0 / oil.air_polytropic_index),
      expansion_(inverse_index_),
      only_nuclei_(oil.air_fraction == 0.0 && oil.air_polytropic_index == 1.0),
      vapour_psi_(oil.vapour_pressure_psi),
      inverse_dissolution_span_(
          oil.dissolution_pressure_psi > 0.0 ? 1.0 / (oil.dissolution_pressure_psi - kAtmospherePsi) : 0.0) {
  // r |theta'| = 1/K_l, theta' = -30 (1 - u)²/(p_d - p_atm) for u near 1.
  if (air_ > 0.0 && inverse_dissolution_span_ > 0.0)
    dissolution_edge_psi_ =
        std::sqrt(inverse_liquid_ / (30.0 * air_ * inverse_dissolution_span_)) / inverse_dissolution_span_;
}

OilModulus::Fraction OilModulus::WithAir(double p_psi, double inverse_gap) const noexcept {
  const double ratio = (kAtmospherePsi - vapour_psi_) * inverse_gap;
  const double expansion = inverse_index_ == 1.0 ? ratio : expansion_(ratio);
  // theta(u) = (1 - u)³ (1 + 3u + 6u²), the free share of the air; theta' = -30 u² (1 - u)².
  const double u_raw = p_psi * inverse_dissolution_span_;
  const double u = u_raw <= 0.0 ? 0.0 : u_raw >= 1.0 ? 1.0 : u_raw;
  const double theta = (1.0 - u) * (1.0 - u) * (1.0 - u) * (1.0 + 3.0 * u + 6.0 * u * u);
  const double theta_slope = -30.0 * u * u * (1.0 - u) * (1.0 - u) * inverse_dissolution_span_;
  const double gas = (air_ * theta + kNuclei) * expansion;
  const double shrinking = gas * inverse_index_ * inverse_gap - air_ * theta_slope * expansion;  // -dV_g/dP
  return {inverse_liquid_ + shrinking, 1.0 + gas};
}

Oil OilAt(const OilParameters& oil) noexcept {
  if (oil.name == OilName::kCustom) return {oil.density_lbf_s2_in4, oil.viscosity_lbf_s_in2};
  constexpr double kPascalSecondsPerReyn = 6894.757;  // 1 lbf s/in²
  constexpr double kKgM3PerLbfS2In4 = 1.0686895e7;    // 4.4482216 N / (0.0254 m)^4
  constexpr double kZeroCelsiusK = 273.15;
  const OilData data = DataOf(oil.name);
  const auto walther = [](double nu_cst) noexcept { return std::log10(std::log10(nu_cst + 0.7)); };
  const double t40 = std::log10(40.0 + kZeroCelsiusK);
  const double t100 = std::log10(100.0 + kZeroCelsiusK);
  const double t = std::log10(oil.temperature_c + kZeroCelsiusK);
  const double w =
      walther(data.nu40_cst) + (walther(data.nu100_cst) - walther(data.nu40_cst)) * (t - t40) / (t100 - t40);
  const double nu_m2_s = 1e-6 * (std::pow(10.0, std::pow(10.0, w)) - 0.7);
  const double rho_kg_m3 = data.density15_kg_m3 * (1.0 - 7e-4 * (oil.temperature_c - 15.0));
  return {rho_kg_m3 / kKgM3PerLbfS2In4, nu_m2_s * rho_kg_m3 / kPascalSecondsPerReyn};
}

}  // namespace servohil::model
