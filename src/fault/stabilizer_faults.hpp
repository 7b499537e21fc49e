#pragma once
/// Faults of the transient flow stabilizer.
/// A part of the catalogue's table: read by catalogue.cpp alone.

#include "fault/parameter_acts.hpp"

namespace servohil::fault {

/// Gas that is lost takes the pressure along at which the diaphragm meets its seat: P V^k of what is left.
inline void LoseGas(P& p, double lost) noexcept {
  model::StabilizerParameters& s = p.stabilizer;
  const double left = 1.0 - lost;
  s.gas_volume_in3 *= left;
  s.precharge_psi += (s.precharge_psi + model::kAtmospherePsi) * (std::pow(left, s.polytropic_index) - 1.0);
}

inline constexpr std::array kStabilizerFaults = std::to_array<Spec>({
    {50,
     "stabilizer_isolated",
     Part::kStabilizer,
     {},
     "The stabilizer's valve is shut: the servomotor is as without one, P8 stays what it is.",
     [](P& p, const V&, double share, double) noexcept { Plug(p.stabilizer.capillary_diameter_in, share); },
     Needs::kStabilizer},
    {51,
     "stabilizer_capillary_plugged",
     Part::kStabilizer,
     {{{"area_lost", "", 0.0, 0.99, 0.5, "share of the capillary's area that is lost"}}},
     "The stabilizer's capillary clogs: less oil comes and goes.",
     [](P& p, const V& v, double share, double) noexcept {
       Plug(p.stabilizer.capillary_diameter_in, share * v[0]);
     },
     Needs::kStabilizer},
    {52,
     "gas_charge_lost",
     Part::kStabilizer,
     {{{"volume_lost", "", 0.0, 0.99, 0.5, "share of the gas that is lost"}}},
     "The stabilizer has lost gas: it takes less oil for the same change of pressure.",
     [](P& p, const V& v, double share, double) noexcept { LoseGas(p, share * v[0]); },
     Needs::kStabilizer},
    {53,
     "diaphragm_ruptured",
     Part::kStabilizer,
     {},
     "The stabilizer's diaphragm has ruptured and 99.9 % of the gas is gone: a volume of oil is left.",
     [](P& p, const V&, double share, double) noexcept { LoseGas(p, share * 0.999); },
     Needs::kStabilizer},
});

}  // namespace servohil::fault
