#include <array>

#include "linear/linearization.hpp"
#include "linear/step_response.hpp"
#include "thesis/groups.hpp"

namespace servohil::thesis {
namespace {

std::string Verdict(const linear::PoleList& poles) {
  return poles.LargestRealPart() < 0.0 ? "stable" : "unstable";
}

void TableIIIGroups(const MakeCase& make, Groups& groups) {
  constexpr std::array kPrinted = {"Stable", "Unstable", "Unstable", "Unstable"};
  int number = 1;
  for (const Row& row : TableIII()) {
    const Case c = make(row);
    Group g("Table III, row " + std::to_string(number), c);
    const char* printed = kPrinted[static_cast<std::size_t>(number - 1)];
    g.Word("by the poles of (B.18), a4 = 0.2901", printed,
           Verdict(linear::Poles(linear::ThesisSystem(c.Coefficients()))));
    g.Word(
        "by the poles of (3.17) as in Appendix D, full a4", printed,
        Verdict(linear::Poles(linear::ThesisSystem(c.Coefficients({.full_a4 = true, .simulation = true})))));
    groups.push_back(g);
    ++number;
  }
}

void RiseTime(const MakeCase& make, Groups& groups) {
  const Case c = make(TableIII()[0]);
  const auto rise_s = [&](const linear::ThesisLinearOptions& options) {
    return linear::FindStepFigures(linear::ThesisSystem(c.Coefficients(options))).rise_s;
  };
  Group g("Section 3.5, Figure 6: rise time to 95 %", c);
  const char* read =
      "read off the plot; a4 = 0.2901 gives 0.0434 s, the full derivative of Appendix D 0.0388 s";
  g.Number("(B.18), a4 = 0.2901", "s", "0.041", rise_s({}), Reason{"0.0434", "13", read});
  g.Number("(3.17) as in Appendix D, full a4", "s", "0.041", rise_s({.full_a4 = true, .simulation = true}),
           Reason{"0.0388", "13", read});
  // Section 5.3 designs the stabilizer by this number.
  g.Number("the same, as section 5.3 quotes it", "s", "0.005", rise_s({}),
           Reason{"0.0434", "new",
                  "section 5.3's \"of the order of 0.005 sec\" is a decimal place off its own Figure 6"});
  groups.push_back(g);
}

}  // namespace

void AppendLinearTables(const MakeCase& make, Groups& groups) {
  TableIIIGroups(make, groups);
  RiseTime(make, groups);
  constexpr std::array kPrinted = {"Unstable", "Stable", "Stable"};
  int number = 1;
  for (const Stabilizer& stabilizer : TableV()) {
    const Case c = make({.stabilizer = stabilizer});
    const char* printed = kPrinted[static_cast<std::size_t>(number - 1)];
    Group g("Table VI, row " + std::to_string(number), c);
    const linear::RouthArray routh =
        linear::Routh(linear::ThesisTransferFunction(c.Coefficients()).denominator);
    g.Word("by the Routh array of (G.15), a4 = 0.2901", printed, routh.Stable() ? "stable" : "unstable");
    g.Word("by the poles of (G.1) to (G.13), full a4", printed,
           Verdict(linear::Poles(linear::ThesisSystem(c.Coefficients({.full_a4 = true})))));
    groups.push_back(g);
    ++number;
  }
  // What the errata say of the nonlinear model's linearisation.
  const auto largest = [](const Case& c) {
    return linear::Poles(linear::Linearize(c.derived, c.rest).system).LargestRealPart();
  };
  const Case iv2 = make(TableIV()[1]);
  Group g2("errata 19: linearised nonlinear model, Table IV row 2", iv2);
  g2.Number("largest real part", "1/s", "19", largest(iv2));
  g2.Number("its frequency", "rad/s", "1575",
            linear::Poles(linear::Linearize(iv2.derived, iv2.rest).system).LeastDamped().FrequencyRadS());
  groups.push_back(g2);
  const Case iv7 = make(TableIV()[6]);
  Group g7("errata 20: linearised nonlinear model, alpha = 0.45 without friction", iv7);
  g7.Number("largest real part", "1/s", "2.1", largest(iv7));
  groups.push_back(g7);
}

}  // namespace servohil::thesis
