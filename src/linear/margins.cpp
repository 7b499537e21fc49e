#include "linear/margins.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace servohil::linear {
namespace {

/// p(j w) = even(w²) + j w odd(w²), both as polynomials in w².
struct OnAxis {
  Polynomial even;
  Polynomial odd;
};

OnAxis Split(const Polynomial& p) noexcept {
  OnAxis parts;
  parts.even.degree = p.degree / 2;
  parts.odd.degree = p.degree > 0 ? (p.degree - 1) / 2 : 0;
  for (int power = 0; power <= p.degree; ++power) {
    const int half = power / 2;
    const double sign = half % 2 == 0 ? 1.0 : -1.0;  // j² = -1
    Polynomial& part = power % 2 == 0 ? parts.even : parts.odd;
    part[part.degree - half] = sign * p[p.degree - power];
  }
  return parts;
}

/// s, or the frequency's square: times it.
Polynomial Raised(const Polynomial& p) noexcept {
  return Polynomial{1.0, 0.0} * p;
}

/// Positive real roots, as frequencies: roots in w² that are real but for rounding. Rising.
template <typename Each>
void ForEachFrequency(const Polynomial& in_square, const Each& each) noexcept {
  for (const Pole& root : Roots(in_square)) {
    if (root.s.real() > 0.0 && std::fabs(root.s.imag()) <= 1e-7 * root.s.real())
      each(std::sqrt(root.s.real()));
  }
}

}  // namespace

TransferFunction PositionLoop(const LinearSystem& closed, const LinearSystem& bushing_held) noexcept {
  const LinearMatrix difference = closed.A - bushing_held.A;
  const TransferFunction by_x4 = ToTransferFunction({bushing_held.A, difference.col(0)});
  const TransferFunction by_v4 = ToTransferFunction({bushing_held.A, difference.col(1)});
  return {Trimmed(-1.0 * (by_x4.numerator + Raised(by_v4.numerator))), by_x4.denominator};
}

double Margins::Upper() const noexcept {
  for (int i = 0; i < gain_limit_count; ++i)
    if (const double f = gain_limits[static_cast<std::size_t>(i)].factor; f > 1.0) return f;
  return 0.0;
}

double Margins::Lower() const noexcept {
  double lower = 0.0;
  for (int i = 0; i < gain_limit_count; ++i)
    if (const double f = gain_limits[static_cast<std::size_t>(i)].factor; f < 1.0) lower = f;
  return lower;
}

const PhaseCrossing* Margins::Phase() const noexcept {
  const auto* const end = phase_crossings.data() + phase_crossing_count;
  const auto* const smallest = std::min_element(phase_crossings.data(), end,
                                                [](const PhaseCrossing& a, const PhaseCrossing& b) noexcept {
                                                  return std::fabs(a.margin_deg) < std::fabs(b.margin_deg);
                                                });
  return smallest == end ? nullptr : smallest;
}

Margins FindMargins(const TransferFunction& loop) noexcept {
  Margins margins;
  const OnAxis n = Split(loop.numerator);
  const OnAxis d = Split(loop.denominator);
  const auto at = [&](double w) { return loop.numerator.At({0.0, w}) / loop.denominator.At({0.0, w}); };
  const auto add_limit = [&](double w) {
    const double real = at(w).real();
    if (!(real < 0.0) || margins.gain_limit_count == Margins::kMax) return;
    margins.gain_limits[static_cast<std::size_t>(margins.gain_limit_count++)] = {-1.0 / real, w};
  };
  // Im(N conj D) = 0: at 0 always, else where odd_n even_d = even_n odd_d.
  add_limit(0.0);
  ForEachFrequency(n.odd * d.even + -1.0 * (n.even * d.odd), add_limit);
  std::sort(margins.gain_limits.begin(), margins.gain_limits.begin() + margins.gain_limit_count,
            [](const GainLimit& a, const GainLimit& b) { return a.factor < b.factor; });

  // |N|² = |D|²
  const auto square = [](const OnAxis& p) { return p.even * p.even + Raised(p.odd * p.odd); };
  ForEachFrequency(square(n) + -1.0 * square(d), [&](double w) {
    const double margin_deg = std::remainder(180.0 + std::arg(at(w)) * 180.0 / std::numbers::pi, 360.0);
    margins.phase_crossings[static_cast<std::size_t>(margins.phase_crossing_count++)] = {margin_deg, w};
  });
  return margins;
}

}  // namespace servohil::linear
