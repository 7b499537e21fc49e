#pragma once
/// Steady state, thesis Appendix A, (A.1) to (A.11): all rates zero, friction not loaded (P3 carries the load
/// alone).

#include <cstdint>

#include "model/derived.hpp"
#include "model/servomotor.hpp"
#include "model/state.hpp"

namespace servohil::model {

enum class SteadyStateError : std::uint8_t {
  kNone,
  kLoadAboveSupply,       ///< the load needs P3 >= P2
  kNoFlowBalance,         ///< no plunger position balances Q3, Q6 and leakage
  kRelayPressureOutside,  ///< the plunger position needs P4 outside (0, P2)
  kRelayPortTooOpen,      ///< even the closed relay port passes more than the capillary delivers
  kRelayPortTooSmall,     ///< not even the fully open relay port passes what the capillary delivers
  kPlungerAtStop,         ///< the plunger would have to be beyond its stops
  kRelayPistonAtStop,     ///< the relay piston would have to be beyond its stops
  kPumpTooSmall,          ///< the pump delivers less than the servomotor consumes at rest
  kNoPositionForP1,       ///< no x3 in [0, stroke] has this P1
};

struct SteadyState {
  SteadyStateError error = SteadyStateError::kNone;
  double p1_psi = 0.0;
  State state;
  Outputs outputs;

  explicit operator bool() const noexcept { return error == SteadyStateError::kNone; }
};

/// At a given piston position [in]; exact to rounding.
SteadyState SteadyStateAt(const Derived& d, double x3_in) noexcept;

/// At a given control pressure [psi]: the lowest x3 in [0, stroke] that has it.
SteadyState SteadyStateForP1(const Derived& d, double p1_psi) noexcept;

}  // namespace servohil::model
