#pragma once
/// Whether the integration resolves what a governor can make of a parameter set, found out before it runs.
///
/// From rest at four positions P1 jumps to 0 and 300 psi, back and forth, and to its value at rest: the
/// piston meets both stops, cavities open and close, plunger, diaphragm and relay port reach theirs; all
/// states occur, none is invented. A tick of many sub-steps is compared with eight steps over the same time.
/// Deterministic. Not for the real-time loop: 5 to 50 ms.

#include <cstdint>

#include "model/derived.hpp"
#include "model/state.hpp"

namespace servohil::model {

inline constexpr double kLowestP1Psi = 0.0;  ///< what a governor may command
inline constexpr double kHighestP1Psi = 300.0;

/// What asks for the sub-steps.
enum class Fastest : std::uint8_t { kRelayChamber, kPistonChamber, kOilStiffness, kMeteringPorts };

/// A tick of the sweep, from `state` under `p1_psi`.
struct SweepTick {
  State state;
  double p1_psi = 0.0;
  double wanted = 0.0;  ///< sub-steps
  Fastest fastest = Fastest::kRelayChamber;
  double rate_1_s = 0.0;  ///< of what is fastest
};

struct EnvelopeSweep {
  int ticks = 0;
  int unresolved_ticks = 0;
  bool left_domain = false;         ///< at `worst`: not finite, or outside IsInDomain
  double x3_error_in = 0.0;         ///< sum over the ticks compared
  double pressure_error_psi = 0.0;  ///< largest of one tick
  SweepTick most;                   ///< the tick that wants most sub-steps
  SweepTick worst;                  ///< the tick of the largest error

  /// x3 within 0.1 % of the stroke, as promised; no single tick wrong by more than 2 % of the supply (RMS of
  /// all ticks: far within the 0.5 % promised).
  bool Accurate(const Derived& d) const noexcept {
    return !left_domain && x3_error_in <= 0.001 * d.stroke_in && pressure_error_psi <= 0.02 * d.P2;
  }
};

EnvelopeSweep SweepEnvelope(const Derived& d) noexcept;

}  // namespace servohil::model
