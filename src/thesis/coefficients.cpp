#include "thesis/groups.hpp"

namespace servohil::thesis {
namespace {

Reason Rounded(std::string right) {
  return {std::move(right), "new", "made from intermediate results rounded to three or four digits"};
}

Reason FromP4(std::string right) {
  return {std::move(right), "1", "follows from P4 = 5.690 and from x1, which belongs to Q4 = 48.9"};
}

}  // namespace

void AppendCoefficients(const MakeCase& make, Groups& groups) {
  const Case at = make({});
  const linear::ThesisCoefficients c = at.Coefficients();
  Group g("Appendix B, parameters and coefficients of (B.18); V3 = 344 in³, k3 = -3450 lbf/in", at);
  g.Number("A1", "in²", "4.106", c.A1);
  g.Number("A2", "in²", "2.341", c.A2);
  g.Number("A2 (Table II)", "in²", "2.314", c.A2, Reason{"2.341", "1", "digits transposed in Table II"});
  g.Number("A3", "in²", "78.38", c.A3);
  g.Number("M", "lbf s²/in", "1.669", c.M);
  g.Number("V3/beta", "in⁵/lbf", "3.127e-3", c.v3_over_beta);
  g.Number("c_r3 (Table II)", "in", "0.002", at.model.servo.piston_clearance_in,
           Reason{"0.001", "2", "every program, and c3 below, use 0.001"});
  g.Number("c3", "in⁵/(lbf s)", "0.186e-3", c.c3);
  g.Number("a1", "in²/s", "15.2e3", c.a1);
  g.Number("a2", "in²/s", "11.0e3", c.a2);
  g.Number("a3", "in²/s", "1.3e3", c.a3);
  g.Number("b1", "in⁵/(lbf s)", "51.8e-3", c.b1);
  g.Number("b2", "in⁵/(lbf s)", "142.2e-3", c.b2);
  g.Number("b3", "in⁵/(lbf s)", "4.29", c.b3, FromP4("4.23452")).note =
      "its arithmetic prints d6 = 3.495 for w1 = 1.750 (not in the errata)";
  g.Number("a4", "lbf s/in⁵", "290.1e-3", c.a4);
  g.Number(
      "a4 by (3.16)", "lbf s/in⁵", "290.1e-3", at.Coefficients({.full_a4 = true}).a4,
      Reason{"11.87", "13", "Appendix B leaves out the factor of (3.16); the program of Appendix D has it"});
  g.Number("B1", "in²/s", "700.67", c.B1, FromP4("695.651"));
  g.Number("B2", "in⁵/(lbf s)", "194.2e-3", c.B2);
  g.Number("B3", "in³/lbf", "39.9e-6", c.B3);
  g.Number("B4", "in²/s", "200.67", c.B4,
           Reason{"1993.55", "14", "a digit is missing: 700.67 + 1300 = 2000.67; exact B1, a3 give this"});
  g.Number("B5", "in²", "78.24", c.B5, Rounded("78.2452"));
  g.Number("B6", "in²/s", "8.38e3", c.B6, Rounded("8388.67"));
  groups.push_back(g);
}

}  // namespace servohil::thesis
