#include "linear/linearization.hpp"

#include <cmath>
#include <limits>

#include "model/servomotor.hpp"

namespace servohil::linear {
namespace {

constexpr int kWidths = 10;
constexpr double kRatio = 1.6;
// The least of 66 differences is small by luck where rounding decides, so that ten times it is not enough
// alone. Rounding of the rates, in which flows of 50 in³/s cancel, was seen to leave 1.5e-10 of an entry
// (linearization_test.cpp).
constexpr double kSafety = 10.0;
constexpr double kRounding = 1e-9;

/// First width of the differences, of the size on which the laws bend: ports 0.002 to 0.04 in (P4 moves the
/// plunger 0.011 in/psi, P1 the relay piston 0.14 in/psi), the load table 0.05 in, pressures 5 psi and more.
double FirstWidth(int state) noexcept {
  switch (state) {
    case model::kX3:
      return 1e-3;
    case model::kP4:
      return 1e-2;
    default:
      return 1e-1;
  }
}
constexpr double kFirstWidthP1 = 1e-2;

struct Derivative {
  model::StateVector value = model::StateVector::Zero();
  model::StateVector error = model::StateVector::Constant(std::numeric_limits<double>::infinity());
};

/// Extrapolates difference(h) to h = 0; its error has the powers `power`, 2 power, 3 power ... of h.
template <typename Difference>
Derivative Extrapolate(const Difference& difference, double first_width, int power) noexcept {
  std::array<model::StateVector, kWidths> last;
  Derivative best;
  for (int k = 0; k < kWidths; ++k) {
    std::array<model::StateVector, kWidths> row;
    row[0] = difference(first_width / std::pow(kRatio, k));
    for (std::size_t m = 1; m <= static_cast<std::size_t>(k); ++m) {
      const double f = std::pow(kRatio, power * static_cast<double>(m));
      row[m] = (f * row[m - 1] - last[m - 1]) / (f - 1.0);
      for (Eigen::Index i = 0; i < row[m].size(); ++i) {
        const double error =
            kSafety * std::fmax(std::fabs(row[m][i] - row[m - 1][i]), std::fabs(row[m][i] - last[m - 1][i]));
        if (!(error <= best.error[i])) continue;
        best.error[i] = error;
        best.value[i] = row[m][i];
      }
    }
    last = row;
  }
  return best;
}

struct Column {
  Derivative derivative;
  bool kinked = false;
};

/// @param f  rates as a function of the displacement from the operating point
template <typename Function>
Column Differentiate(const Function& f, double first_width) noexcept {
  const model::StateVector middle = f(0.0);
  // What is left of the rates at rest is rounding as well; it may vary with the displacement.
  const auto with_rounding = [&](Derivative d) noexcept {
    d.error += kRounding * d.value.cwiseAbs() + middle.cwiseAbs() / first_width;
    return d;
  };
  const auto right_at = [&](double h) noexcept { return model::StateVector((f(h) - middle) / h); };
  const auto left_at = [&](double h) noexcept { return model::StateVector((middle - f(-h)) / h); };
  const Derivative right = Extrapolate(right_at, first_width, 1);
  const Derivative left = Extrapolate(left_at, first_width, 1);
  for (Eigen::Index i = 0; i < middle.size(); ++i) {
    const double jump = std::fabs(right.value[i] - left.value[i]);
    // Rounding of one-sided differences stays far below 1e-6 of a slope; the smallest kink of a load table
    // that matters does not.
    const double noise = 10.0 * (right.error[i] + left.error[i]) +
                         1e-6 * (std::fabs(right.value[i]) + std::fabs(left.value[i]));
    if (jump > noise) return {with_rounding(right), true};
  }
  const auto central = [&](double h) noexcept { return model::StateVector((f(h) - f(-h)) / (2.0 * h)); };
  Derivative best = Extrapolate(central, first_width, 2);
  // An odd law with a term Q |Q| (end losses of a capillary at rest) is smooth once, not twice: central
  // differences then err by the first power of the width, which only the one-sided extrapolations take out.
  for (Eigen::Index i = 0; i < middle.size(); ++i) {
    const double error = std::fmax(right.error[i], left.error[i]) + std::fabs(right.value[i] - left.value[i]);
    if (!(error < best.error[i])) continue;
    best.error[i] = error;
    best.value[i] = 0.5 * (right.value[i] + left.value[i]);
  }
  return {with_rounding(best), false};
}

/// The states that evolve by themselves: without a stabilizer P8 only repeats P3, without a pump P2 is
/// constant.
int IndependentStates(const model::Derived& d, std::array<int, kMaxOrder>& states) noexcept {
  static_assert(model::StateVector::RowsAtCompileTime <= kMaxOrder);
  int n = 0;
  for (int i = 0; i < model::StateVector::RowsAtCompileTime; ++i) {
    if (i == model::kP8 && !d.stabilizer) continue;
    if (i == model::kP2 && d.pump_flow <= 0.0) continue;
    states[static_cast<std::size_t>(n++)] = i;
  }
  return n;
}

}  // namespace

Linearization Linearize(const model::Derived& d, const model::SteadyState& point) noexcept {
  Linearization result;
  const int n = IndependentStates(d, result.states);
  LinearMatrix& A = result.system.A;  // NOLINT(readability-identifier-naming)
  LinearVector& B = result.system.B;  // NOLINT(readability-identifier-naming)
  A.resize(n, n);
  B.resize(n);
  result.A_error.resize(n, n);
  result.B_error.resize(n);

  const model::StateVector y = point.state.Vector();
  model::Mode mode = point.state.mode;
  mode.motion = model::Motion::kFree;
  const auto entry = [&](int i) noexcept { return result.states[static_cast<std::size_t>(i)]; };
  for (int j = 0; j < n; ++j) {
    const auto rates = [&](double displacement) noexcept {
      model::StateVector moved = y;
      moved[entry(j)] += displacement;
      if (entry(j) == model::kP3 && !d.stabilizer) moved[model::kP8] += displacement;
      return model::Rates(d, moved, mode, point.p1_psi);
    };
    const Column column = Differentiate(rates, FirstWidth(entry(j)));
    result.kinked[static_cast<std::size_t>(j)] = column.kinked;
    for (int i = 0; i < n; ++i) {
      A(i, j) = column.derivative.value[entry(i)];
      result.A_error(i, j) = column.derivative.error[entry(i)];
    }
  }
  const auto rates = [&](double displacement) noexcept {
    return model::Rates(d, y, mode, point.p1_psi + displacement);
  };
  const Column column = Differentiate(rates, kFirstWidthP1);
  for (int i = 0; i < n; ++i) {
    B[i] = column.derivative.value[entry(i)];
    result.B_error[i] = column.derivative.error[entry(i)];
  }

  const LinearVector factor = BalanceFactors(A);
  const auto balanced = [&](const LinearMatrix& m) {
    return LinearMatrix(factor.cwiseInverse().asDiagonal() * m * factor.asDiagonal());
  };
  result.relative_error = balanced(result.A_error).maxCoeff() / balanced(A).cwiseAbs().maxCoeff();
  return result;
}

model::Parameters WithBushingHeld(const model::Parameters& parameters, double x3_in) noexcept {
  model::Parameters held = parameters;
  held.cam.shape = model::CamShape::kSingle;
  held.cam.alpha = 0.0;
  held.cam.x3_star_in = model::Cam(parameters.cam).At(x3_in);
  return held;
}

}  // namespace servohil::linear
