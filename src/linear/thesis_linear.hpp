#pragma once
/// The thesis' simplified linear model: section 3.2, Appendix B (four states), Appendix G (with the transient
/// flow stabilizer, five). Against the linearised nonlinear model it leaves out: radial clearances (but in
/// the steady state), viscous damping C, the oil's compressibility above the relay plunger and in the
/// stabilizer (V4/beta, V8/beta); V3 and the load's slope k3 are constants.

#include "linear/transfer_function.hpp"
#include "model/steady_state.hpp"

namespace servohil::linear {

struct ThesisLinearOptions {
  /// false: a4 = 128 mu L4 / (pi d4⁴) = 0.2901 as Appendix B prints it; true: times the factor of (3.16), the
  /// derivative of (2.3), as the program of Appendix D has it (errata 13).
  bool full_a4 = false;
  /// true: with C and V4/beta, as in (3.15) and the program of Appendix D.
  bool simulation = false;
  double v3_in3 = 344.0;       ///< V3 of Table II, at x3 = 4.0 in
  double k3_lbf_in = -3450.0;  ///< k3, slope of the load force at x3 = 4.0 in, read off Figure 3
};

/// Symbols of Appendix B and G; units in, lbf, s, psi.
// NOLINTBEGIN(readability-identifier-naming)
struct ThesisCoefficients {
  double k3, v3_over_beta, M, alpha, A1, A2, A3, k1, k2, c3, C, V4_over_beta;
  double a1, a2, a3;  ///< flow over opening [in²/s], (3.4) to (3.6)
  double b1, b2, b3;  ///< flow over pressure [in⁵/(lbf s)]
  double a4;          ///< capillary [lbf s/in⁵], (3.16)
  double B1, B2, B3, B4, B5, B6;
  bool stabilizer;
  double a5;      ///< 1/R of the stabilizer's capillary [in⁵/(lbf s)], 0 without one
  double C8;      ///< V_a / (k P8) [in⁵/lbf]
  double B7, B8;  ///< B7 = tau_p = R C8 [s]
};
// NOLINTEND(readability-identifier-naming)

/// @pre point is a steady state of d = Derived(p)
ThesisCoefficients ThesisCoefficientsAt(const model::Parameters& p, const model::Derived& d,
                                        const model::SteadyState& point,
                                        const ThesisLinearOptions& options) noexcept;

/// (B.18), or (G.15) with a stabilizer; in (G.15)'s C3 the product (a1 + a2) B7 lacks alpha (the sum that it
/// comes from, and the thesis' own numbers, have it). Without what `simulation` adds.
TransferFunction ThesisTransferFunction(const ThesisCoefficients& c) noexcept;

/// (3.13) to (3.15), and (G.5), (G.11), (G.12): states x3, v3, P3, P4 and with a stabilizer P8.
LinearSystem ThesisSystem(const ThesisCoefficients& c) noexcept;

}  // namespace servohil::linear
