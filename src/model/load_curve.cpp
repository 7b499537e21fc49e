#include "model/load_curve.hpp"

namespace servohil::model {

LoadCurve::LoadCurve(std::span<const Point> points) noexcept : size_(points.size()) {
  for (std::size_t i = 0; i < size_; ++i) {
    x_[i] = points[i].x3_in;
    p_[i] = points[i].p3_psi;
  }
  for (std::size_t i = 0; i + 1 < size_; ++i) slope_[i] = (p_[i + 1] - p_[i]) / (x_[i + 1] - x_[i]);
  slope_[size_ - 1] = slope_[size_ - 2];
  const double width_in = x_[size_ - 1] - x_[0];
  bins_per_in_ = kBins / width_in;
  std::size_t segment = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const double left_in = x_[0] + width_in * static_cast<double>(bin) / kBins;
    while (segment + 2 < size_ && x_[segment + 1] <= left_in) ++segment;
    // One before, so that rounding of the bin number at its edge cannot overshoot the segment.
    first_segment_[bin] = static_cast<std::uint8_t>(segment > 0 ? segment - 1 : 0);
  }
}

LoadCurve LoadCurve::Held() const noexcept {
  constexpr double kBeyondIn = 1.0;  // any: a flat segment is extended flat
  std::array<Point, kMaxPoints + 2> points{};
  points[0] = {x_[0] - kBeyondIn, p_[0]};
  for (std::size_t i = 0; i < size_; ++i) points[i + 1] = (*this)[i];
  points[size_ + 1] = {x_[size_ - 1] + kBeyondIn, p_[size_ - 1]};
  return LoadCurve(std::span(points.data(), size_ + 2));
}

LoadCurve LoadCurve::Shifted(double psi) const noexcept {
  LoadCurve shifted = *this;
  for (std::size_t i = 0; i < size_; ++i) shifted.p_[i] += psi;
  return shifted;
}

LoadCurve LoadCurve::HeldBetween(double from_in, double to_in, double share) const noexcept {
  LoadCurve held = *this;
  if (share == 0.0) return held;  // to the last bit
  const double held_psi = PressureAt(from_in);
  for (std::size_t i = 0; i < size_; ++i) {
    if (x_[i] > from_in && x_[i] <= to_in) held.p_[i] += share * (held_psi - p_[i]);
  }
  for (std::size_t i = 0; i + 1 < size_; ++i)
    held.slope_[i] = (held.p_[i + 1] - held.p_[i]) / (x_[i + 1] - x_[i]);
  held.slope_[size_ - 1] = held.slope_[size_ - 2];
  return held;
}

}  // namespace servohil::model
