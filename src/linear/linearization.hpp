#pragma once
/// State matrix A and input vector B of the nonlinear model at an operating point, from Rates() alone:
///   A = dRates/dy,   B = dRates/dP1   of the sliding, frictionless piston (Motion::kFree)
/// Derivatives are central differences extrapolated to zero width (Ridders 1982): 10 widths, each 1.6 times
/// smaller, and of all extrapolations the one that differs least from its neighbours; ten times that
/// difference and 1e-9 of the entry for rounding is the error bound stated with each entry. Where the model
/// has a kink (a row of the load table, the knee of the two-slope cam, a port just closed) the two one-sided
/// derivatives differ: then the one to the right (of larger x3) is taken, and the column is reported as
/// kinked.
/// Where a law is smooth only once (end losses Q |Q| of a capillary at rest) the mean of the one-sided
/// extrapolations is taken, since it has the smaller bound.
///
/// Dry friction (Coulomb, breakaway, Stribeck) has no linear model: below breakaway a stuck piston does not
/// move at all, above it friction takes energy out of every swing. The linear model is that of the piston
/// without it.

#include <array>

#include "linear/linear_system.hpp"
#include "model/parameters.hpp"
#include "model/steady_state.hpp"

namespace servohil::linear {

struct Linearization {
  LinearSystem system;
  std::array<int, kMaxOrder> states{};  ///< StateIndex of each row of the system
  LinearMatrix A_error;                 ///< NOLINT(readability-identifier-naming): bound of |error| per entry
  LinearVector B_error;                 ///< NOLINT(readability-identifier-naming)
  /// Largest error bound, relative to the largest entry, both of the balanced A.
  double relative_error = 0.0;
  std::array<bool, kMaxOrder> kinked{};  ///< per column of A: left and right derivatives differ
};

/// @pre point is a steady state of d
Linearization Linearize(const model::Derived& d, const model::SteadyState& point) noexcept;

/// The same servomotor with its bushing held where the cam puts it at x3: x4 = const. Opens the position
/// loop.
model::Parameters WithBushingHeld(const model::Parameters& parameters, double x3_in) noexcept;

}  // namespace servohil::linear
