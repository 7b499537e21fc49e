#pragma once
/// A state under parameters that have changed while it ran (a fault, a setting): continuous where oil, mass
/// and gas are, with the mode that holds now.

#include "model/derived.hpp"
#include "model/state.hpp"

namespace servohil::model {

/// Position, velocity and the chambers' pressures stay; a constant supply has its new pressure at once, a
/// stabilizer that is gone has P8 = P3; motion, stops, seat and port follow from the state. Real-time safe.
State Reconciled(const Derived& d, const State& state, double p1_psi) noexcept;

}  // namespace servohil::model
