#include "linear/polynomial.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace servohil::linear {

Polynomial::Polynomial(std::initializer_list<double> coefficients) noexcept
    : degree(static_cast<int>(coefficients.size()) - 1) {
  std::copy(coefficients.begin(), coefficients.end(), c.begin());
}

std::complex<double> Polynomial::At(std::complex<double> s) const noexcept {
  std::complex<double> value = 0.0;
  for (int i = 0; i <= degree; ++i) value = value * s + (*this)[i];
  return value;
}

Polynomial operator+(const Polynomial& a, const Polynomial& b) noexcept {
  const Polynomial& longer = a.degree >= b.degree ? a : b;
  const Polynomial& shorter = a.degree >= b.degree ? b : a;
  Polynomial sum = longer;
  const int offset = longer.degree - shorter.degree;
  for (int i = 0; i <= shorter.degree; ++i) sum[i + offset] += shorter[i];
  return sum;
}

Polynomial operator*(const Polynomial& a, const Polynomial& b) noexcept {
  Polynomial product;
  product.degree = a.degree + b.degree;
  for (int i = 0; i <= a.degree; ++i)
    for (int j = 0; j <= b.degree; ++j) product[i + j] += a[i] * b[j];
  return product;
}

Polynomial operator*(double factor, const Polynomial& a) noexcept {
  Polynomial product = a;
  for (int i = 0; i <= a.degree; ++i) product[i] *= factor;
  return product;
}

Polynomial Trimmed(const Polynomial& a) noexcept {
  int zeros = 0;
  while (zeros < a.degree && a[zeros] == 0.0) ++zeros;
  Polynomial trimmed;
  trimmed.degree = a.degree - zeros;
  for (int i = 0; i <= trimmed.degree; ++i) trimmed[i] = a[i + zeros];
  return trimmed;
}

PoleList Roots(const Polynomial& polynomial) noexcept {
  using Companion = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, Polynomial::kMaxDegree,
                                  Polynomial::kMaxDegree>;
  Polynomial p = Trimmed(polynomial);
  PoleList roots;
  while (p.degree > 0 && p[p.degree] == 0.0) {
    --p.degree;
    roots.items[static_cast<std::size_t>(roots.size++)].s = 0.0;
  }
  const int n = p.degree;
  if (n == 0) return roots;
  const double scale = std::pow(std::fabs(p[n] / p[0]), 1.0 / n);
  Companion companion = Companion::Zero(n, n);
  for (int i = 1; i <= n; ++i) companion(0, i - 1) = -p[i] / (p[0] * std::pow(scale, i));
  for (int i = 1; i < n; ++i) companion(i, i - 1) = 1.0;
  const Eigen::EigenSolver<Companion> solver(companion, false);
  for (int i = 0; i < n; ++i)
    roots.items[static_cast<std::size_t>(roots.size++)].s = scale * solver.eigenvalues()[i];
  std::sort(roots.items.begin(), roots.items.begin() + roots.size, [](const Pole& a, const Pole& b) {
    const auto key = [](const Pole& pole) { return std::hypot(pole.s.real(), std::fabs(pole.s.imag())); };
    return key(a) != key(b) ? key(a) < key(b) : a.s.imag() > b.s.imag();
  });
  return roots;
}

}  // namespace servohil::linear
