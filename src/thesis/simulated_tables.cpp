/// Tables IV and VII: verdicts of the nonlinear simulation.
///
/// From the peak-to-peak swing of the velocity v3 after 0.27 psi from rest at 4.0 in. The criteria and their
/// margins are those of tests/data/reference/definitions.py, checked there with an independent solver.
///   over the thesis' 0.1 s   unstable: the swing in 0.08 to 0.10 s is not below that in 0.06 to 0.08 s
///   over 1 s                 stable: in 0.9 to 1.0 s below a tenth of that in 0.1 to 0.2 s, or below 1e-3
///   in/s
///                            (at rest); unstable: above half of it and above 1 in/s (every limit cycle of
///                            the tables swings more than 2 in/s)

#include <algorithm>
#include <array>
#include <cmath>

#include "thesis/groups.hpp"

namespace servohil::thesis {
namespace {

struct Verdicts {
  std::string window;
  std::string second;
};

Verdicts Simulate(const Case& c) {
  constexpr int kTicks = 10'000;
  std::vector<double> v3_in_s = {0.0};
  simulation::Simulation simulation(c.model, c.rest);
  for (int i = 0; i < kTicks; ++i) v3_in_s.push_back(simulation.Tick(c.rest.p1_psi + kStepPsi).state.v3_in_s);
  const auto swing = [&](double from_s, double to_s) {
    const auto at = [&](double t_s) { return v3_in_s.begin() + std::lround(t_s / model::kTickS); };
    const auto [low, high] = std::minmax_element(at(from_s), at(to_s) + 1);
    return *high - *low;
  };
  if (simulation.Now().model_fault) return {"invalid", "invalid"};
  const double early = swing(0.1, 0.2);
  const double late = swing(0.9, 1.0);
  const bool grows = late > 0.5 * early && late > 1.0;
  const bool decays = late < std::max(0.1 * early, 1e-3);
  return {swing(0.08, 0.10) < swing(0.06, 0.08) ? "stable" : "unstable", grows    ? "unstable"
                                                                         : decays ? "stable"
                                                                                  : "undecided"};
}

void Append(Groups& groups, const std::string& where, const Case& c, const char* printed,
            std::optional<Reason> window_reason = {}, std::optional<Reason> second_reason = {}) {
  const Verdicts verdicts = Simulate(c);
  Group g(where, c);
  g.Word("over the thesis' 0.1 s", printed, verdicts.window, std::move(window_reason));
  g.Word("over 1 s", printed, verdicts.second, std::move(second_reason));
  groups.push_back(g);
}

}  // namespace

void AppendSimulatedTables(const MakeCase& make, Groups& groups) {
  constexpr std::array kTableIV = {"Stable",
                                   "Stable",
                                   "Stable, lightly damped",
                                   "Unstable",
                                   "Stable, oscillatory",
                                   "Stable due to Coulomb friction",
                                   "Stable due to Coulomb friction"};
  const Reason row_2{
      "unstable", "19",
      "the thesis integrated 0.1 s, in which it decays; linearly unstable (+19 1/s, 1575 rad/s), it then "
      "grows to a limit cycle of about 7 in/s"};
  for (std::size_t i = 0; i < TableIV().size(); ++i) {
    Append(groups, "Table IV, row " + std::to_string(i + 1), make(TableIV()[i]), kTableIV.at(i), {},
           i == 1 ? std::optional(row_2) : std::nullopt);
  }
  const Reason text{
      "unstable", "new",
      "the text (\"stable, but very lightly damped\") contradicts its Table IV, row 4, which is right"};
  Append(groups, "Section 4.3, text on Figures 22 and 23", make(TableIV()[3]),
         "Stable, but very lightly damped", text, text);
  Row free = TableIV()[6];
  free.coulomb_psi = 0.0;
  Append(groups, "Section 4.3, Table IV row 7 without Coulomb friction", make(free), "Unstable");
  constexpr std::array kTableVII = {"Unstable", "Stable", "Stable, lightly damped", "Stable", "Stable"};
  for (std::size_t i = 0; i < TableVII().size(); ++i) {
    Append(groups, "Table VII, row " + std::to_string(i + 1), make(CompensatedRow(TableVII()[i])),
           kTableVII.at(i));
  }
}

}  // namespace servohil::thesis
