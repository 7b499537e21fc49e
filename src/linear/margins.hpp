#pragma once
/// Stability margins of the position loop, broken at the cam feedback: the bushing x4 is held by an outside
/// hand, the piston's answer alpha x3 is what the cam would have set it to.
///   L(s) = -(alpha x3)/x4,   closed loop: 1 + L(s) = 0
/// With A of the servomotor and A_o of the same one with its bushing held, A - A_o = D has only the columns
/// of x3 (by x4) and v3 (by dx4/dt), so that L(s) = -c (sI - A_o)⁻¹ (D_x3 + s D_v3), c picks x3. Opened so,
/// the piston on a load that falls with x3 drifts off slowly (a real pole near +0.1 1/s): L has a pole in the
/// right half plane, and the gain may neither rise nor fall without limit.

#include <array>

#include "linear/transfer_function.hpp"

namespace servohil::linear {

/// L(s). @pre both systems have the states x3, v3 first and the same order
TransferFunction PositionLoop(const LinearSystem& closed, const LinearSystem& bushing_held) noexcept;

/// A factor on the loop gain at which closed-loop poles lie on the imaginary axis, at ± frequency.
struct GainLimit {
  double factor = 0.0;
  double frequency_rad_s = 0.0;
};

struct PhaseCrossing {
  double margin_deg = 0.0;  ///< 180° + arg L(j frequency), -180 to 180
  double frequency_rad_s = 0.0;
};

struct Margins {
  static constexpr int kMax = Polynomial::kMaxDegree;
  std::array<GainLimit, kMax> gain_limits{};  ///< rising factors, all positive
  int gain_limit_count = 0;
  std::array<PhaseCrossing, kMax> phase_crossings{};  ///< rising frequencies, where |L| = 1
  int phase_crossing_count = 0;

  /// Smallest factor above 1; 0: none. The gain margin towards more gain of a stable loop.
  double Upper() const noexcept;
  /// Largest factor below 1; 0: none. How far the gain may fall.
  double Lower() const noexcept;
  /// The crossing with the smallest |margin|; nullptr: |L| is never 1.
  const PhaseCrossing* Phase() const noexcept;
};

/// All crossings, as roots of polynomials in the frequency's square: none is missed between grid points.
Margins FindMargins(const TransferFunction& loop) noexcept;

}  // namespace servohil::linear
