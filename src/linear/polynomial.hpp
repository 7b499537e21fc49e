#pragma once
/// Real polynomials in s of low degree, no allocation.

#include <array>
#include <complex>
#include <initializer_list>

#include "linear/linear_system.hpp"

namespace servohil::linear {

/// c[0] s^degree + c[1] s^(degree - 1) + ... + c[degree]
struct Polynomial {
  static constexpr int kMaxDegree = 2 * kMaxOrder;

  Polynomial() = default;
  /// Descending powers. @pre 1 to kMaxDegree + 1 coefficients
  Polynomial(std::initializer_list<double> coefficients) noexcept;

  double operator[](int i) const noexcept { return c[static_cast<std::size_t>(i)]; }
  double& operator[](int i) noexcept { return c[static_cast<std::size_t>(i)]; }
  std::complex<double> At(std::complex<double> s) const noexcept;

  int degree = 0;
  std::array<double, kMaxDegree + 1> c{};
};

Polynomial operator+(const Polynomial& a, const Polynomial& b) noexcept;
Polynomial operator*(const Polynomial& a, const Polynomial& b) noexcept;
Polynomial operator*(double factor, const Polynomial& a) noexcept;
/// Without the leading coefficients that are exactly 0.
Polynomial Trimmed(const Polynomial& a) noexcept;

/// Eigenvalues of the companion matrix, s scaled so that the roots are about 1; the slowest first. Leading
/// zeros are ignored; roots at 0 are exact. A degree above kMaxOrder (as for margins) is fine up to
/// kMaxDegree.
PoleList Roots(const Polynomial& p) noexcept;

}  // namespace servohil::linear
