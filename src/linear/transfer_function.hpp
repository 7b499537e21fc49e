#pragma once
/// Transfer function x3/P1 of a linear system, its Routh array, and the margins of the position loop.

#include <array>

#include "linear/polynomial.hpp"

namespace servohil::linear {

struct TransferFunction {
  Polynomial numerator;
  Polynomial denominator;
};

/// x3/P1 [in/psi], the denominator monic, by Faddeev and LeVerrier's recursion in extended precision on the
/// balanced matrix. A coefficient that is 0 by the structure of A comes out exactly 0.
TransferFunction ToTransferFunction(const LinearSystem& system) noexcept;

/// Routh array of a polynomial, as in section 3.6 of the thesis: the number of sign changes in the first
/// column is the number of roots in the right half plane.
///   A zero in the first column of a row that is not zero stands for a small positive number ("epsilon
///   method"). A row of zeros (roots symmetric about the origin) is replaced by the derivative of the
///   polynomial that the row above it stands for; such roots on the imaginary axis are not in the right half
///   plane, but there.
/// An element counts as zero below 1e-12 of the products it is the difference of.
struct RouthArray {
  static constexpr int kMaxRows = Polynomial::kMaxDegree + 1;
  static constexpr int kMaxColumns = Polynomial::kMaxDegree / 2 + 1;

  std::array<std::array<double, kMaxColumns>, kMaxRows> rows{};
  int row_count = 0;
  int column_count = 0;
  int sign_changes = 0;
  bool zero_element = false;  ///< the epsilon method was used
  bool zero_row = false;      ///< an auxiliary polynomial was used

  double First(int row) const noexcept { return rows[static_cast<std::size_t>(row)][0]; }
  /// No root in the right half plane or on the imaginary axis.
  bool Stable() const noexcept { return sign_changes == 0 && !zero_element && !zero_row; }
};

/// @pre degree >= 1, leading coefficient not 0
RouthArray Routh(const Polynomial& p) noexcept;

}  // namespace servohil::linear
