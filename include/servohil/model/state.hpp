#pragma once
/// What evolves.

#include <Eigen/Core>
#include <cstdint>

namespace servohil::model {

/// Continuous state as a vector, in the order of the thesis' Y(1) to Y(5) (Appendix E, H).
using StateVector = Eigen::Matrix<double, 5, 1>;
enum StateIndex : std::uint8_t { kX3, kV3, kP3, kP4, kP8 };

/// How the piston moves: decides the sign of Coulomb friction. Constant between two events.
enum class Motion : std::uint8_t {
  kFree,   ///< no Coulomb friction: the velocity may have any sign
  kStuck,  ///< at rest, held by friction
  kUp,     ///< sliding, v3 >= 0
  kDown,   ///< sliding, v3 <= 0
};

/// Trivially copyable: crosses threads as it is.
struct State {
  double x3_in = 0.0;    ///< piston position, upward opens the steam valves
  double v3_in_s = 0.0;  ///< piston velocity
  double p3_psi = 0.0;   ///< under the piston, gauge
  double p4_psi = 0.0;   ///< above the relay plunger, gauge
  double p8_psi = 0.0;   ///< stabilizer's oil chamber, gauge; P3 where there is none
  Motion motion = Motion::kFree;

  StateVector Vector() const noexcept { return StateVector(x3_in, v3_in_s, p3_psi, p4_psi, p8_psi); }
  static State From(const StateVector& y, Motion motion) noexcept {
    return {y[kX3], y[kV3], y[kP3], y[kP4], y[kP8], motion};
  }
};

}  // namespace servohil::model
