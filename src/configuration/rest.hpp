#pragma once
/// The steady state of a servomotor, or why there is none.

#include "model/derived.hpp"
#include "model/steady_state.hpp"

namespace servohil::configuration {

/// Returns the steady state at a piston position.
/// @throws UsageError that says why there is none, and what would have one
model::SteadyState RequireSteadyStateAt(const model::Derived& derived, double x3_in);

/// Returns the steady state under a control pressure. @throws UsageError as above
model::SteadyState RequireSteadyStateForP1(const model::Derived& derived, double p1_psi);

}  // namespace servohil::configuration
