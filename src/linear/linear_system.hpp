#pragma once
/// Linear model dy/dt = A y + B u about an operating point, u: change of P1 [psi], output: state 0, x3 [in].
/// Sizes are bounded at compile time: nothing here allocates. Not for the real-time loop: no bound on time.

#include <Eigen/Core>
#include <array>
#include <complex>

namespace servohil::linear {

inline constexpr int kMaxOrder = 8;

using LinearMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxOrder, kMaxOrder>;
using LinearVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxOrder, 1>;

struct LinearSystem {
  LinearMatrix A;  ///< NOLINT(readability-identifier-naming): the symbol of the literature
  LinearVector B;  ///< NOLINT(readability-identifier-naming)
};

/// One mode: s = real ± j imaginary [1/s].
struct Pole {
  std::complex<double> s;
  double FrequencyRadS() const noexcept { return std::abs(s); }
  /// -Re s / |s|: 1 for a decaying real pole, 0 on the imaginary axis, negative when unstable.
  double Damping() const noexcept { return std::abs(s) > 0.0 ? -s.real() / std::abs(s) : 0.0; }
};

struct PoleList {
  static constexpr int kMax = 16;
  std::array<Pole, kMax> items{};
  int size = 0;

  const Pole* begin() const noexcept { return items.data(); }       // NOLINT(readability-identifier-naming)
  const Pole* end() const noexcept { return items.data() + size; }  // NOLINT(readability-identifier-naming)
  double LargestRealPart() const noexcept;
  /// The least damped one. @pre size > 0
  const Pole& LeastDamped() const noexcept;
};

/// Factors D (powers of 2, so exact) such that D⁻¹ A D has rows and columns of like size (Parlett and Reinsch
/// 1969): states in in and psi differ by factors of 1e6.
LinearVector BalanceFactors(const LinearMatrix& matrix) noexcept;

/// Eigenvalues of A, the slowest first; complex pairs adjacent. Relative accuracy about 1e-12 |largest| /
/// |each|.
PoleList Poles(const LinearSystem& system) noexcept;

}  // namespace servohil::linear
