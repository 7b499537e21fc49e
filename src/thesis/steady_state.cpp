#include <cmath>
#include <numbers>

#include "configuration/rest.hpp"
#include "thesis/groups.hpp"

namespace servohil::thesis {
namespace {

constexpr const char* kPi = "the printed formula lacks pi, the number has it (not in the errata)";
constexpr const char* kArea = "needs A2 = 2.348 in² (the listings' 2.34E); with 2.341 it is this";
constexpr const char* kFlow =
    "belongs to P4 = 5.690 and Q4 = 48.9, where (A.3) gives 48.40 (with A2 = 2.348, too)";

void AppendixA(const MakeCase& make, Groups& groups) {
  using std::numbers::pi;
  const Case c = make({});
  const model::Derived& d = c.derived;
  Group g("Appendix A, estimates", c);
  const double d3 = c.model.servo.piston_diameter_in;
  const double piston_in3 = pi / 4.0 * (d3 * d3 * 2.5 + 2.996 * 2.996 * 30.25);
  g.Number("m3, from its drawing", "lbf s²/in", "0.303", 0.286 / 386.0 * piston_in3);
  const double x4_in = 9.3 * d.A1 / d.k1;
  g.Number("delta x4 for 9.3 psi", "in", "1.27", x4_in);
  g.Number("alpha = delta x4 / 4.0 in", "", "0.32", x4_in / 4.0);
  g.Number("x1 at P1 = 35.0 psi", "in", "4.79", 35.0 * d.A1 / d.k1).note = kPi;
  g.Number("x3* = x1 - 0.32 * 6.0", "in", "2.87", 35.0 * d.A1 / d.k1 - 0.32 * 6.0);
  const Reason measured{"", "new",
                        "measured in the field, Figure 4; alpha = 0.32 and x3* = 2.90 are a fit to it"};
  const auto fit = [&](const char* right) { return Reason{right, measured.errata, measured.text}; };
  g.Number("P1 at x3 = 2.0 in, Curve B", "psi", "25.7", configuration::RequireSteadyStateAt(d, 2.0).p1_psi,
           fit("25.576"));
  g.Number("P1 at x3 = 6.0 in, Curve B", "psi", "35.0", configuration::RequireSteadyStateAt(d, 6.0).p1_psi,
           fit("34.932"));
  groups.push_back(g);

  const Case two = make({.two_slope_cam = true});
  Group knee("Appendix A, two-slope cam (Figure 4, Curve A)", two);
  const double knee_in = two.derived.cam.knee_x3_in();
  knee.Number("x3 where the slope changes", "in", "2.9", knee_in,
              Reason{"2.8444", "8", "the two lines meet there; at 2.9 in they differ by 0.025 in"});
  knee.Number("P1 where the slope changes", "psi", "34.25",
              configuration::RequireSteadyStateAt(two.derived, knee_in).p1_psi,
              Reason{"33.756", "8", "P1 where the lines meet"});
  groups.push_back(knee);
}

}  // namespace

void AppendSteadyState(const MakeCase& make, Groups& groups) {
  AppendixA(make, groups);
  const Case c = make({});
  const model::SteadyState& s = c.rest;
  Group g("Appendix B, steady state at x3 = 4.0 in", c);
  g.Number("x1", "in", "4.14167", s.outputs.x1_in, Reason{"4.142101", "new", kFlow});
  g.Number("x2", "in", "4.17934", s.outputs.x2_in);
  g.Number("x4", "in", "4.18000", s.outputs.x4_in);
  g.Number("P3", "psi", "103.00", s.state.p3_psi);
  g.Number("P4", "psi", "5.690", s.state.p4_psi, Reason{"5.70702", "1", kArea});
  g.Number("P1 (Appendix H, PINT)", "psi", "30.26", s.p1_psi);
  g.Number(
      "Q4 (Appendix E, H: X0)", "in³/s", "48.9", s.outputs.q4_in3_s,
      Reason{"48.4026", "11", "a start value of the iteration, not its result; x1 as printed has the same"});
  groups.push_back(g);

  const Case steep = make({.alpha = 0.90, .x3_star_in = 2.10});
  Group listing("Appendix E, listing with alpha = 0.90, x3* = 2.10", steep);
  listing.Number("P1 at x3 = 4.0 in (PINT)", "psi", "41.57", steep.rest.p1_psi,
                 Reason{"41.3687", "new",
                        "does not belong to the alpha and x3* listed with it, or a digit of the scan"});
  groups.push_back(listing);

  const model::Derived& d = c.derived;
  Group step("Section 3.4", c);
  step.Number("x1", "in", "4.141674", s.outputs.x1_in, Reason{"4.142101", "new", kFlow});
  step.Number("x2", "in", "4.179339", s.outputs.x2_in,
              Reason{"4.1793402", "new", "one unit of the last of seven digits: single precision"});
  step.Number("delta P1 that closes orifice 5, printed x1, x2", "psi", "0.275",
              d.k1 / d.A1 * (4.179339 - 4.141674))
      .note = kPi;
  step.Number("delta P1 that closes orifice 5, exact x1, x2", "psi", "0.275",
              d.k1 / d.A1 * (s.outputs.x2_in - s.outputs.x1_in),
              Reason{"0.272079", "new", "difference of x1 and x2, of which x1 deviates"});
  const double k_s = d.A3 * d.A3 * c.model.servo.bulk_modulus_psi / 344.0;
  const double omega_n = std::sqrt((k_s - 3450.0) / d.M);
  step.Number("k_s, spring of the oil", "lbf/in", "1.965e6", k_s);
  step.Number("omega_n", "rad/s", "1.08e3", omega_n);
  step.Number("T = 2 pi / omega_n", "s", "5.8e-3", 2.0 * std::numbers::pi / omega_n);
  groups.push_back(step);
}

}  // namespace servohil::thesis
