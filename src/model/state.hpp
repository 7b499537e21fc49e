#pragma once
/// What evolves.

#include <Eigen/Core>
#include <cstdint>

namespace servohil::model {

/// Continuous state as a vector: the thesis' Y(1) to Y(5) (Appendix E, H), and the supply pressure.
using StateVector = Eigen::Matrix<double, 6, 1>;
enum StateIndex : std::uint8_t { kX3, kV3, kP3, kP4, kP8, kP2 };

/// How the piston moves.
enum class Motion : std::uint8_t {
  kFree,         ///< no friction: the velocity may have any sign
  kStuck,        ///< at rest, held by friction
  kUp,           ///< sliding, v3 >= 0
  kDown,         ///< sliding, v3 <= 0
  kAtLowerStop,  ///< at rest on the stop at x3 = 0
  kAtUpperStop,  ///< at rest on the stop at x3 = stroke
};

/// Where the relay plunger is between its stops.
enum class Plunger : std::uint8_t { kFree, kAtLowerStop, kAtUpperStop };

/// What is constant between two events: decides which equations hold.
struct Mode {
  Mode() = default;
  Mode(Motion piston) noexcept : motion(piston) {}  // NOLINT(google-explicit-constructor): a motion is a mode

  Motion motion = Motion::kFree;
  Plunger plunger = Plunger::kFree;
  bool diaphragm_seated = false;
  bool relay_port_full =
      false;  ///< orifice 5 open to its height: a kink in its flow, where sub-steps are cut

  bool PistonRests() const noexcept {
    return motion == Motion::kStuck || motion == Motion::kAtLowerStop || motion == Motion::kAtUpperStop;
  }
};

/// Trivially copyable: crosses threads as it is.
struct State {
  double x3_in = 0.0;    ///< piston position, upward opens the steam valves
  double v3_in_s = 0.0;  ///< piston velocity
  double p3_psi = 0.0;   ///< under the piston, gauge
  double p4_psi = 0.0;   ///< above the relay plunger, gauge
  double p8_psi = 0.0;   ///< stabilizer's oil chamber, gauge; P3 where there is none
  double p2_psi = 0.0;   ///< supply, gauge
  Mode mode;

  StateVector Vector() const noexcept {
    StateVector y;
    y << x3_in, v3_in_s, p3_psi, p4_psi, p8_psi, p2_psi;
    return y;
  }
  static State From(const StateVector& y, const Mode& mode) noexcept {
    return {y[kX3], y[kV3], y[kP3], y[kP4], y[kP8], y[kP2], mode};
  }
};

}  // namespace servohil::model
