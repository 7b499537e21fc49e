#include <array>
#include <numbers>

#include "thesis/groups.hpp"

namespace servohil::thesis {
namespace {

Reason Product(const char* right) {
  return {right, "new", "product of R and C as rounded in the table"};
}

Reason Tau17(const char* right) {
  return {right, "17", "R C = 0.166 * 0.693 = 0.115 s"};
}

}  // namespace

void AppendStabilizerTables(const MakeCase& make, Groups& groups) {
  const Case c = make({.stabilizer = TableV()[0]});
  Group g("Section 5.4, capacitance and (5.10)", c);
  const double p8_psi = c.rest.state.p3_psi;
  const double k = c.model.stabilizer.polytropic_index;
  g.Number("C per volume, V8 = V_a", "1/psi", "0.0069",
           1.0 / c.model.servo.bulk_modulus_psi + 1.0 / (k * p8_psi));
  g.Number("tau_p / ((L7/d7⁴) V_a)", "s/in", "622e-9",
           128.0 * c.model.oil.viscosity_lbf_s_in2 / std::numbers::pi / (k * p8_psi));
  groups.push_back(g);

  struct Printed {
    const char* d7;
    const char* resistance;
    const char* capacitance;
    const char* tau;
    std::optional<Reason> d7_reason, resistance_reason, tau_reason;
  };
  const std::array<Printed, 3> v = {{{"0.005",
                                      "35.85",
                                      "0.139",
                                      "4.98",
                                      Reason{"0.05", "17", "only 0.05 in gives R = 35.85"},
                                      {},
                                      Product("4.97287")},
                                     {"0.150", "1.33", "0.680", "0.90", {}, {}, {}},
                                     {"0.300", "0.166", "0.693", "0.05", {}, {}, Tau17("0.115113")}}};
  const std::array<Printed, 5> vii = {{{"0.10", "7.350", "0.680", "5.0", {}, {}, {}},
                                       {"0.15",
                                        "1.330",
                                        "0.680",
                                        "0.90",
                                        {},
                                        Reason{"1.32794", "new", "1.33 of Table V with a zero added"},
                                        {}},
                                       {"0.14", "2.800", "0.139", "0.39", {}, {}, {}},
                                       {"0.30", "0.166", "0.693", "0.05", {}, {}, Tau17("0.115113")},
                                       {"0.30", "0.166", "0.139", "0.023", {}, {}, {}}}};
  const auto append = [&](const std::string& where, const auto& printed, const std::vector<Stabilizer>& rows,
                          double underlap_in, double clearance_in) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const Printed& p = printed.at(i);
      const Case at = make({.underlap_in = underlap_in, .clearance_in = clearance_in, .stabilizer = rows[i]});
      const linear::ThesisCoefficients t = at.Coefficients();
      Group row(where + ", row " + std::to_string(i + 1), at);
      row.Number("d7", "in", p.d7, at.model.stabilizer.capillary_diameter_in, p.d7_reason);
      row.Number("R", "lbf s/in⁵", p.resistance, 1.0 / t.a5, p.resistance_reason);
      row.Number("C = V_a / (k P8)", "in⁵/lbf", p.capacitance, t.C8);
      row.Number("tau_p = R C", "s", p.tau, t.B7, p.tau_reason);
      groups.push_back(row);
    }
  };
  append("Table V", v, TableV(), 0.002, 0.002);
  append("Table VII", vii, TableVII(), 0.001, 0.0);
}

}  // namespace servohil::thesis
