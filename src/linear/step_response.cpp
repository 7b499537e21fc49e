#include "linear/step_response.hpp"

#include <algorithm>

#include "linear/transfer_function.hpp"

namespace servohil::linear {
namespace {

using Augmented = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxOrder + 1, kMaxOrder + 1>;

Augmented Exponential(const Augmented& m) noexcept {
  const double norm = m.cwiseAbs().rowwise().sum().maxCoeff();
  const int squarings = norm > 0.25 ? static_cast<int>(std::ceil(std::log2(norm / 0.25))) : 0;
  const Augmented scaled = m * std::exp2(-squarings);
  Augmented sum = Augmented::Identity(m.rows(), m.cols());
  Augmented term = sum;
  for (int k = 1; k <= 12; ++k) {  // 0.25^13 / 13! < 1e-17
    term = (term * scaled / k).eval();
    sum += term;
  }
  for (int i = 0; i < squarings; ++i) sum = (sum * sum).eval();
  return sum;
}

}  // namespace

StepResponse::StepResponse(const LinearSystem& system, double interval_s) noexcept
    : state_(LinearVector::Zero(system.A.rows())) {
  const Eigen::Index n = system.A.rows();
  const LinearVector d = BalanceFactors(system.A);
  Augmented m = Augmented::Zero(n + 1, n + 1);
  m.topLeftCorner(n, n) = d.cwiseInverse().asDiagonal() * system.A * d.asDiagonal() * interval_s;
  m.topRightCorner(n, 1) = d.cwiseInverse().cwiseProduct(system.B) * interval_s;
  const Augmented e = Exponential(m);
  transition_ = d.asDiagonal() * e.topLeftCorner(n, n) * d.cwiseInverse().asDiagonal();
  input_ = d.asDiagonal() * e.topRightCorner(n, 1);
}

StepFigures FindStepFigures(const LinearSystem& system) noexcept {
  constexpr double kSamples = 5e6;
  StepFigures figures;
  const PoleList poles = Poles(system);
  const double slowest = -poles.LargestRealPart();
  if (!(slowest > 0.0)) return figures;
  double fastest = 0.0;
  for (const Pole& pole : poles) fastest = std::max(fastest, pole.FrequencyRadS());
  const double end_s = 10.0 / slowest;  // e^-10 = 5e-5
  const double interval_s = std::max(0.02 / fastest, end_s / kSamples);

  const TransferFunction t = ToTransferFunction(system);
  figures.final_in_psi = t.numerator[t.numerator.degree] / t.denominator[t.denominator.degree];
  StepResponse response(system, interval_s);
  double before = 0.0;  // x3 over its final value
  double largest = 0.0;
  figures.settling_s = 0.0;
  const auto samples = static_cast<long>(end_s / interval_s);
  for (long i = 1; i <= samples; ++i) {
    response.Advance();
    const double now = response.Now()[0] / figures.final_in_psi;
    // Time at which the line from `before` to `now` passes a level.
    const auto time_at = [&](double level) {
      return interval_s * (static_cast<double>(i - 1) + (level - before) / (now - before));
    };
    if (std::isnan(figures.rise_s) && now >= 0.95) figures.rise_s = time_at(0.95);
    if (std::fabs(before - 1.0) > 0.02 && std::fabs(now - 1.0) <= 0.02)
      figures.settling_s = time_at(before < 1.0 ? 0.98 : 1.02);
    largest = std::max(largest, now);
    before = now;
  }
  figures.overshoot = std::max(0.0, largest - 1.0);
  return figures;
}

}  // namespace servohil::linear
