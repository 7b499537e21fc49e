#include <cmath>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "linear/analysis.hpp"

namespace servohil::linear {
namespace {

using nlohmann::ordered_json;

constexpr double kRadPerTurn = 2.0 * std::numbers::pi;

double Decibel(double factor) {
  return 20.0 * std::log10(factor);
}

/// null where there is no such number: JSON has no NaN.
ordered_json OrNull(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

ordered_json List(const Polynomial& p) {
  ordered_json list = ordered_json::array();
  for (int i = 0; i <= p.degree; ++i) list.push_back(p[i]);
  return list;
}

void PrintPolynomial(const char* name, const Polynomial& p) {
  std::printf("  %-12s", name);
  for (int i = 0; i <= p.degree; ++i) {
    const int power = p.degree - i;
    std::printf("%s%.6g", i > 0 ? " + " : " ", p[i]);
    if (power > 0) std::printf(" s");
    if (power > 1) std::printf("^%d", power);
  }
  std::printf("\n");
}

void PrintMargins(const Margins& m) {
  std::printf("\nposition loop, broken at the bushing x4 (cam feedback)\n");
  for (int i = 0; i < m.gain_limit_count; ++i) {
    const GainLimit& limit = m.gain_limits[static_cast<std::size_t>(i)];
    std::printf("  gain limit    x %.6g (%+.2f dB) at %.6g rad/s\n", limit.factor, Decibel(limit.factor),
                limit.frequency_rad_s);
  }
  if (const PhaseCrossing* phase = m.Phase()) {
    std::printf("  phase margin  %.4g deg at %.6g rad/s\n", phase->margin_deg, phase->frequency_rad_s);
  } else {
    std::printf("  phase margin  none: the loop gain is never 1\n");
  }
}

void PrintStep(const StepFigures& step) {
  std::printf("\nstep response of x3 to P1\n");
  if (std::isnan(step.final_in_psi)) {
    std::printf("  none: unstable, there is no final value\n");
    return;
  }
  std::printf("  final value   %.6g in/psi\n", step.final_in_psi);
  std::printf("  rise to 95 %%  %.4g s\n", step.rise_s);
  std::printf("  overshoot     %.3g %%\n", 100.0 * step.overshoot);
  std::printf("  settling 2 %%  %.4g s\n", step.settling_s);
}

}  // namespace

void PrintText(const LinearAnalysis& a) {
  const model::SteadyState& rest = a.point.rest;
  std::printf("operating point: x3 %.6g in, P1 %.6g psi, P3 %.6g psi, P4 %.6g psi\n", rest.state.x3_in,
              rest.p1_psi, rest.state.p3_psi, rest.state.p4_psi);
  for (const std::string& note : a.point.notes) std::printf("note: %s\n", note.c_str());

  std::printf("\nstate matrix A | input vector B (change of P1 [psi])");
  if (a.point.jacobian_relative_error)
    std::printf("; error at most %.1e of the largest entry, balanced", *a.point.jacobian_relative_error);
  std::printf("\n  %-9s", "d/dt");
  for (const std::string& name : a.point.states) std::printf(" %13s", name.c_str());
  std::printf(" | %13s\n", "p1_psi");
  for (std::size_t i = 0; i < a.point.states.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    std::printf("  %-9s", a.point.states[i].c_str());
    for (Eigen::Index j = 0; j < a.point.system.A.cols(); ++j)
      std::printf(" %13.6g", a.point.system.A(row, j));
    std::printf(" | %13.6g\n", a.point.system.B[row]);
  }

  std::printf("\ntransfer function x3/P1 [in/psi]\n");
  PrintPolynomial("numerator", a.transfer.numerator);
  PrintPolynomial("denominator", a.transfer.denominator);

  std::printf("\npoles [1/s]                        frequency               damping\n");
  for (const Pole& pole : a.poles) {
    std::printf("  %12.6g %+13.6g j   %10.5g rad/s %9.4g Hz   %8.4g\n", pole.s.real(), pole.s.imag(),
                pole.FrequencyRadS(), pole.FrequencyRadS() / kRadPerTurn, pole.Damping());
  }
  std::printf("\nRouth first column:");
  for (int i = 0; i < a.routh.row_count; ++i) std::printf(" %.6g", a.routh.First(i));
  std::printf(
      "\n  %d sign changes: %s%s\n", a.routh.sign_changes, a.routh.Stable() ? "stable" : "unstable",
      a.routh.zero_row || a.routh.zero_element ? " (or on the limit: a zero in the first column)" : "");
  PrintMargins(a.margins);
  PrintStep(a.step);
}

void PrintJson(const LinearAnalysis& a) {
  const model::SteadyState& rest = a.point.rest;
  ordered_json out;
  out["operating_point"] = {{"x3_in", rest.state.x3_in},   {"p1_psi", rest.p1_psi},
                            {"p3_psi", rest.state.p3_psi}, {"p4_psi", rest.state.p4_psi},
                            {"x1_in", rest.outputs.x1_in}, {"x2_in", rest.outputs.x2_in},
                            {"x4_in", rest.outputs.x4_in}, {"q4_in3_s", rest.outputs.q4_in3_s}};
  out["notes"] = a.point.notes;
  out["states"] = a.point.states;
  out["a"] = ordered_json::array();
  out["b"] = ordered_json::array();
  for (Eigen::Index i = 0; i < a.point.system.A.rows(); ++i) {
    ordered_json row = ordered_json::array();
    for (Eigen::Index j = 0; j < a.point.system.A.cols(); ++j) row.push_back(a.point.system.A(i, j));
    out["a"].push_back(row);
    out["b"].push_back(a.point.system.B[i]);
  }
  if (a.point.jacobian_relative_error) out["jacobian_relative_error"] = *a.point.jacobian_relative_error;
  out["transfer_function"] = {{"numerator_in_psi", List(a.transfer.numerator)},
                              {"denominator", List(a.transfer.denominator)}};
  out["poles"] = ordered_json::array();
  for (const Pole& pole : a.poles) {
    out["poles"].push_back({{"real_1_s", pole.s.real()},
                            {"imaginary_1_s", pole.s.imag()},
                            {"frequency_rad_s", pole.FrequencyRadS()},
                            {"frequency_hz", pole.FrequencyRadS() / kRadPerTurn},
                            {"damping", pole.Damping()}});
  }
  ordered_json column = ordered_json::array();
  for (int i = 0; i < a.routh.row_count; ++i) column.push_back(a.routh.First(i));
  out["routh"] = {{"first_column", column},
                  {"sign_changes", a.routh.sign_changes},
                  {"zero_element", a.routh.zero_element},
                  {"zero_row", a.routh.zero_row}};
  out["stable"] = a.routh.Stable();
  ordered_json limits = ordered_json::array();
  for (int i = 0; i < a.margins.gain_limit_count; ++i) {
    const GainLimit& limit = a.margins.gain_limits[static_cast<std::size_t>(i)];
    limits.push_back(
        {{"factor", limit.factor}, {"db", Decibel(limit.factor)}, {"rad_s", limit.frequency_rad_s}});
  }
  const PhaseCrossing* phase = a.margins.Phase();
  out["position_loop"] = {
      {"numerator", List(a.loop.numerator)},
      {"denominator", List(a.loop.denominator)},
      {"gain_limits", limits},
      {"phase_margin_deg", phase ? ordered_json(phase->margin_deg) : ordered_json(nullptr)},
      {"phase_margin_rad_s", phase ? ordered_json(phase->frequency_rad_s) : ordered_json(nullptr)}};
  out["step_response"] = {{"final_in_psi", OrNull(a.step.final_in_psi)},
                          {"rise_95_s", OrNull(a.step.rise_s)},
                          {"overshoot", OrNull(a.step.overshoot)},
                          {"settling_2_s", OrNull(a.step.settling_s)}};
  std::cout << out.dump(2) << '\n';
}

}  // namespace servohil::linear
