#pragma once
/// Where one mode of the servomotor ends and which follows.

#include <array>

#include "model/derived.hpp"
#include "model/state.hpp"

namespace servohil::model {

/// A quantity that is not negative while the mode lasts, and its rate of change.
struct Validator {
  double value;
  double rate;
};

/// Piston: two; plunger: two; diaphragm, relay port: one each. Those that a mode does not need are {1, 0}.
using Guards = std::array<Validator, 6>;

/// The guards of `mode` at a state with the given rates. Real-time safe.
Guards GuardsOf(const Derived& d, const State& state, double p1_psi, const StateVector& rates) noexcept;

/// A validator of `state` is negative: something happened on the way there. Real-time safe.
bool AnyGuardEnded(const Derived& d, const State& state, double p1_psi) noexcept;

/// What follows when validator `index` has fallen to 0: the state with its new mode. Real-time safe.
State AfterEvent(const Derived& d, const State& state, std::size_t index) noexcept;

/// The motion that follows rest between the stops. Real-time safe.
Motion MotionFromRest(const Derived& d, const State& state) noexcept;

}  // namespace servohil::model
