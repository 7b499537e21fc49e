#pragma once
/// Flow laws. Pure, real-time safe. Odd in the pressure difference.

#include <cmath>
#include <limits>

namespace servohil::model {

/// Square of the effective opening of a port with radial clearance: x² + c² for x > 0, c² otherwise, (2.4) to
/// (2.6), and no more than at the port's height h. [in²]
inline double OpeningSquared(double x, double c, double h) noexcept {
  const double open = x <= 0.0 ? 0.0 : x >= h ? h : x;  // in this order a NaN is not swallowed
  return open * open + c * c;
}

/// Flow through a sharp-edged orifice, thesis (2.4) to (2.6):
///   Q = sgn(dP) k sqrt(x² + c²) sqrt|dP|   for x > 0,   sgn(dP) k c sqrt|dP|   otherwise
///   Q [in³/s]   dP [psi]   x opening [in]   c radial clearance [in]   k = c_d pi d sqrt(2/rho)
/// Its slope is infinite at dP = 0.
inline double OrificeFlow(double dP, double x, double c, double k) noexcept {
  constexpr double kNoHeight = std::numeric_limits<double>::infinity();
  return std::copysign(k * std::sqrt(OpeningSquared(x, c, kNoHeight) * std::fabs(dP)), dP);
}

/// The same with laminar flow at small pressure differences, as a conductance G = Q/dP [in³/(s psi)]:
///   Q = k a dP / (dP² + p_t²)^¼,   a² opening squared [in²], p_t > 0 transition pressure [psi]
/// Continuous with its slope everywhere; k a dP / sqrt(p_t) around 0; below (2.4) to (2.6) by less than 0.1 %
/// from |dP| = 15.8 p_t on; 0 < dQ/ddP <= G. The transition of Simscape Fluids' orifices; physics: Merritt
/// (1967), 3.4.
inline double OrificeConductance(double dP, double a_squared, double k, double p_t) noexcept {
  return k * std::sqrt(a_squared / std::sqrt(dP * dP + p_t * p_t));
}

/// Flow through the capillary in the relay plunger, laminar with entrance loss, thesis (2.3):
///   dP = a Q (1 + b Q)   =>   Q = (-1 + sqrt(1 + 4 b dP / a)) / (2 b) = 2 dP / (a + sqrt(a² + 4 a b dP))
///   a = 128 mu L4 / (pi d4⁴) [lbf s/in⁵]   b = 2.28 rho / (16 pi mu L4) [s/in³]
/// The one physical root (errata 11), written so that nothing cancels and b may be 0.
inline double CapillaryFlow(double dP, double a, double b) noexcept {
  return 2.0 * dP / (a + std::sqrt(a * a + 4.0 * a * b * std::fabs(dP)));
}

}  // namespace servohil::model
