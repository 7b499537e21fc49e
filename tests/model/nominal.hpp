#pragma once
/// Parameter sets that several tests begin from.

#include <array>

#include "model/derived.hpp"

namespace servohil::model::testing {

/// Appendix E's table, as in config/load_curve.csv.
inline LoadCurve ThesisLoad() {
  constexpr std::array kPoints = std::to_array<LoadCurve::Point>({
      {1.00, 67.5}, {1.25, 63.5}, {1.50, 60.5}, {1.75, 56.5},  {2.0, 53.5},   {2.25, 51.0}, {2.5, 49.0},
      {2.75, 47.5}, {3.0, 46.5},  {3.25, 45.5}, {3.35, 45.0},  {3.4, 131.0},  {3.5, 127.0}, {3.75, 115.},
      {4.0, 103.0}, {4.25, 91.0}, {4.50, 80.5}, {4.75, 74.5},  {5.0, 71.0},   {5.25, 69.0}, {5.50, 67.0},
      {5.75, 67.0}, {6.0, 67.0},  {6.25, 67.0}, {6.3, 150.0},  {6.50, 135.5}, {6.75, 124.}, {7.00, 116.5},
      {7.25, 111.}, {7.50, 107.}, {7.75, 105.}, {8.00, 103.0},
  });
  return LoadCurve(kPoints);
}

/// Table II with the errata, the thesis' equations.
inline Parameters Nominal() {
  Parameters p;
  p.physics = Physics::kThesis;
  p.load.opening = ThesisLoad();
  return p;
}

/// Nominal with Coulomb friction [psi].
inline Parameters WithFriction(double coulomb_psi) {
  Parameters p = Nominal();
  p.friction.coulomb_psi = coulomb_psi;
  return p;
}

}  // namespace servohil::model::testing
