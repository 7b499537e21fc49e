#pragma once
/// Feedback cam and follow-up lever, thesis (2.15), Figure 4:
///   x4 = alpha x3 + x3*
///   x3, x4 [in]   alpha [-]   x3* [in]
/// The two-slope cam follows its lower line up to where the lines meet (x3 = 2.8444 in for curve A; the
/// thesis' 2.9 in leaves a jump of 0.025 in, errata 8) and its upper line from there, so x4 is continuous.
/// Real-time safe.

#include <limits>

#include "model/parameters.hpp"

namespace servohil::model {

class Cam {
 public:
  explicit Cam(const CamParameters& p) noexcept
      : lower_{p.alpha, p.x3_star_in}, upper_{p.alpha, p.x3_star_in} {
    if (p.shape == CamShape::kTwoSlope) {
      lower_ = {p.lower_alpha, p.lower_x3_star_in};
      upper_ = {p.upper_alpha, p.upper_x3_star_in};
      knee_x3_in_ = (upper_.x3_star_in - lower_.x3_star_in) / (lower_.alpha - upper_.alpha);
    }
  }

  /// Bushing position x4 [in].
  double At(double x3_in) const noexcept {
    const Line& line = LineAt(x3_in);
    return line.alpha * x3_in + line.x3_star_in;
  }
  /// dx4/dx3 [-], to the right of the knee where it jumps.
  double SlopeAt(double x3_in) const noexcept { return LineAt(x3_in).alpha; }
  /// Where the two lines meet [in]; infinite for a single slope.
  double knee_x3_in() const noexcept { return knee_x3_in_; }  // NOLINT(readability-identifier-naming)

 private:
  struct Line {
    double alpha;
    double x3_star_in;
  };
  const Line& LineAt(double x3_in) const noexcept { return x3_in < knee_x3_in_ ? lower_ : upper_; }

  Line lower_;
  Line upper_;
  double knee_x3_in_ = std::numeric_limits<double>::infinity();
};

}  // namespace servohil::model
