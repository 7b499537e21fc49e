#include "linear/analysis.hpp"

#include <array>
#include <cmath>

#include "base/formatted.hpp"
#include "configuration/rest.hpp"

namespace servohil::linear {
namespace {

constexpr std::array kStateNames = {"x3_in", "v3_in_s", "p3_psi", "p4_psi", "p8_psi", "p2_psi"};

model::SteadyState Rest(const model::Derived& derived, const LinearOptions& options) {
  return options.x3_in ? configuration::RequireSteadyStateAt(derived, *options.x3_in)
                       : configuration::RequireSteadyStateForP1(derived, *options.p1_psi);
}

void NoteKinks(const Linearization& linear, LinearPoint& point) {
  for (std::size_t i = 0; i < point.states.size(); ++i) {
    if (!linear.kinked[i]) continue;
    point.notes.push_back("the model has a kink in " + point.states[i] +
                          " at this point (a row of the load table, the cam's knee, a port just closed): the "
                          "matrix holds to its "
                          "right, where it is larger; a little to the left it is another");
  }
}

/// The thesis' constants of one operating point, used at another.
void NoteThesisConstants(const model::Derived& d, const LinearOptions& options, LinearPoint& point) {
  const double x3_in = point.rest.state.x3_in;
  const double v3_in3 = d.V3_at_zero + d.A3 * x3_in;
  const double k3_lbf_in = d.A3 * d.load_up.SlopeAt(x3_in);
  point.notes.push_back(
      base::Formatted(
          "V3 = %g in3 and k3 = %g lbf/in as given (--v3, --k3; default: the thesis', for x3 = 4.0 in); ",
          options.thesis.v3_in3, options.thesis.k3_lbf_in) +
      base::Formatted("the configuration has %g in3 and %g lbf/in at this point", v3_in3, k3_lbf_in));
  const double opening_in = std::fabs(point.rest.outputs.x2_in - point.rest.outputs.x4_in);
  if (opening_in > d.U) {
    point.notes.push_back(
        base::Formatted("the plunger stands %g in off its bushing, beyond the underlap of %g in: the thesis' "
                        "linear orifices (3.5), (3.6) do not hold here",
                        opening_in, d.U));
  }
}

/// Dry friction and hysteresis have no linear model. Viscous friction has one and is in the matrix.
void NoteFriction(const model::Derived& d, const model::FrictionParameters& friction, LinearPoint& point) {
  if (d.F_breakaway > 0.0) {
    const double breakaway_psi = d.F_breakaway / d.A3;
    const bool stribeck = d.F_breakaway > d.F_coulomb;
    std::string note = base::Formatted("friction.coulomb_psi = %g psi", friction.coulomb_psi);
    if (stribeck)
      note += base::Formatted(" with breakaway_psi = %g psi and the Stribeck curve between", breakaway_psi);
    note += base::Formatted(
        " is left out: this is the sliding, frictionless piston. A stuck one does not move at all until P3 "
        "has "
        "risen by %g or fallen by %g psi",
        breakaway_psi, d.closing_ratio * breakaway_psi);
    if (stribeck) note += "; a slow one loses damping where friction falls with speed";
    point.notes.push_back(note);
  }
  if (d.directional &&
      d.load_up.PressureAt(point.rest.state.x3_in) != d.load_down.PressureAt(point.rest.state.x3_in))
    point.notes.emplace_back("the load is that of opening: load.closing_file is left out");
}

}  // namespace

LinearPoint LinearPointOf(const model::Parameters& parameters, const LinearOptions& options) {
  const model::Derived derived(parameters);
  LinearPoint point;
  point.rest = Rest(derived, options);
  if (options.model == LinearModel::kThesis) {
    const auto c = ThesisCoefficientsAt(parameters, derived, point.rest, options.thesis);
    point.system = ThesisSystem(c);
    for (Eigen::Index i = 0; i < point.system.A.rows(); ++i)
      point.states.emplace_back(kStateNames[static_cast<std::size_t>(i)]);
    NoteThesisConstants(derived, options, point);
  } else {
    const Linearization linear = Linearize(derived, point.rest);
    point.system = linear.system;
    for (Eigen::Index i = 0; i < point.system.A.rows(); ++i) {
      const auto state = static_cast<std::size_t>(linear.states[static_cast<std::size_t>(i)]);
      point.states.push_back(state < kStateNames.size() ? kStateNames[state]
                                                        : "state_" + std::to_string(state));
    }
    point.jacobian_relative_error = linear.relative_error;
    NoteKinks(linear, point);
  }
  NoteFriction(derived, parameters.friction, point);
  return point;
}

LinearAnalysis Analyse(const model::Parameters& parameters, const LinearOptions& options) {
  LinearAnalysis a;
  a.point = LinearPointOf(parameters, options);
  a.poles = Poles(a.point.system);
  a.transfer = ToTransferFunction(a.point.system);

  const double x3_in = a.point.rest.state.x3_in;
  const model::Parameters held = WithBushingHeld(parameters, x3_in);
  const model::Derived held_derived(held);
  if (options.model == LinearModel::kThesis) {
    const auto c = ThesisCoefficientsAt(parameters, model::Derived(parameters), a.point.rest, options.thesis);
    // The scale of (B.18) and (G.15), so that the numbers can be laid beside the thesis'.
    const double scale = ThesisTransferFunction(c).denominator[0];
    a.transfer.numerator = scale * a.transfer.numerator;
    a.transfer.denominator = scale * a.transfer.denominator;
    auto open = c;
    open.alpha = 0.0;
    a.loop = PositionLoop(a.point.system, ThesisSystem(open));
  } else {
    a.loop = PositionLoop(a.point.system, Linearize(held_derived, a.point.rest).system);
  }
  a.routh = Routh(a.transfer.denominator);
  a.margins = FindMargins(a.loop);
  a.step = FindStepFigures(a.point.system);
  return a;
}

}  // namespace servohil::linear
