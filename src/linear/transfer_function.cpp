#include "linear/transfer_function.hpp"

#include <cmath>

namespace servohil::linear {
namespace {

using Wide = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxOrder, kMaxOrder>;
using WideVector = Eigen::Matrix<long double, Eigen::Dynamic, 1, 0, kMaxOrder, 1>;

constexpr double kZero = 1e-12;  // 1e4 times the rounding of one product: a computed zero is below it

}  // namespace

TransferFunction ToTransferFunction(const LinearSystem& system) noexcept {
  const LinearVector d = BalanceFactors(system.A);
  const Wide A =  // NOLINT(readability-identifier-naming)
      (d.cwiseInverse().asDiagonal() * system.A * d.asDiagonal()).eval().cast<long double>();
  const WideVector b = d.cwiseInverse().cwiseProduct(system.B).cast<long double>();
  const auto n = static_cast<int>(A.rows());

  // adj(sI - A) = sum over k of N_k s^(n-1-k);  N_0 = I,  N_k = A N_(k-1) + a_k I,  a_k = -tr(A N_(k-1)) / k
  TransferFunction result;
  result.denominator.degree = n;
  result.numerator.degree = n - 1;
  result.denominator[0] = 1.0;
  Wide N = Wide::Identity(n, n);  // NOLINT(readability-identifier-naming)
  for (int k = 1; k <= n; ++k) {
    result.numerator[k - 1] = static_cast<double>(N.row(0).dot(b)) * d[0];
    N = (A * N).eval();
    long double trace = 0.0L;
    for (int i = 0; i < n; ++i) trace += N(i, i);
    const long double a = -trace / static_cast<long double>(k);
    result.denominator[k] = static_cast<double>(a);
    for (int i = 0; i < n; ++i) N(i, i) += a;
  }
  result.numerator = Trimmed(result.numerator);
  return result;
}

RouthArray Routh(const Polynomial& p) noexcept {
  RouthArray array;
  array.row_count = p.degree + 1;
  array.column_count = p.degree / 2 + 1;
  const auto columns = static_cast<std::size_t>(array.column_count);
  for (int i = 0; i <= p.degree; ++i)
    array.rows[static_cast<std::size_t>(i % 2)][static_cast<std::size_t>(i / 2)] = p[i];

  for (std::size_t r = 1; r < static_cast<std::size_t>(array.row_count); ++r) {
    auto& row = array.rows[r];
    if (r >= 2) {
      const auto& above = array.rows[r - 1];
      const auto& second = array.rows[r - 2];
      for (std::size_t j = 0; j + 1 < columns; ++j) {
        const double left = above[0] * second[j + 1];
        const double right = second[0] * above[j + 1];
        const bool zero = std::fabs(left - right) <= kZero * (std::fabs(left) + std::fabs(right));
        row[j] = zero ? 0.0 : (left - right) / above[0];
      }
    }
    bool all_zero = true;
    for (std::size_t j = 0; j < columns; ++j) all_zero = all_zero && row[j] == 0.0;
    const int power = p.degree - static_cast<int>(r);  // this row is that of s^power
    if (all_zero) {
      array.zero_row = true;
      // The row above stands for a polynomial in s^(power+1), s^(power-1), ...: its derivative.
      for (std::size_t j = 0; j < columns; ++j) {
        const int exponent = power + 1 - 2 * static_cast<int>(j);
        row[j] = exponent > 0 ? exponent * array.rows[r - 1][j] : 0.0;
      }
    }
    if (row[0] == 0.0) {
      array.zero_element = true;
      row[0] = 1e-30;  // positive, and far below every coefficient of a servomotor
    }
  }
  for (int r = 1; r < array.row_count; ++r)
    if (std::signbit(array.First(r)) != std::signbit(array.First(r - 1))) ++array.sign_changes;
  return array;
}

}  // namespace servohil::linear
