#include "linear/linear_system.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace servohil::linear {

double PoleList::LargestRealPart() const noexcept {
  double largest = -HUGE_VAL;
  for (const Pole& pole : *this) largest = std::max(largest, pole.s.real());
  return largest;
}

const Pole& PoleList::LeastDamped() const noexcept {
  return *std::min_element(begin(), end(),
                           [](const Pole& a, const Pole& b) { return a.Damping() < b.Damping(); });
}

LinearVector BalanceFactors(const LinearMatrix& matrix) noexcept {
  const Eigen::Index n = matrix.rows();
  LinearVector factor = LinearVector::Ones(n);
  LinearMatrix a = matrix;
  for (int sweep = 0; sweep < 100; ++sweep) {
    bool changed = false;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double column = a.col(i).cwiseAbs().sum() - std::fabs(a(i, i));
      const double row = a.row(i).cwiseAbs().sum() - std::fabs(a(i, i));
      if (column == 0.0 || row == 0.0) continue;
      const double f = std::exp2(std::round(0.5 * std::log2(row / column)));
      if (column * f + row / f >= 0.95 * (column + row)) continue;
      a.col(i) *= f;
      a.row(i) /= f;
      factor[i] *= f;
      changed = true;
    }
    if (!changed) break;
  }
  return factor;
}

PoleList Poles(const LinearSystem& system) noexcept {
  const LinearVector d = BalanceFactors(system.A);
  const LinearMatrix balanced = d.cwiseInverse().asDiagonal() * system.A * d.asDiagonal();
  const Eigen::EigenSolver<LinearMatrix> solver(balanced, false);
  PoleList poles;
  poles.size = static_cast<int>(system.A.rows());
  for (int i = 0; i < poles.size; ++i) poles.items[static_cast<std::size_t>(i)].s = solver.eigenvalues()[i];
  std::sort(poles.items.begin(), poles.items.begin() + poles.size, [](const Pole& a, const Pole& b) {
    // The two of a pair have the same modulus but for rounding: compare what is equal in both to the bit.
    const auto key = [](const Pole& p) { return std::hypot(p.s.real(), std::fabs(p.s.imag())); };
    return key(a) != key(b) ? key(a) < key(b) : a.s.imag() > b.s.imag();
  });
  return poles;
}

}  // namespace servohil::linear
