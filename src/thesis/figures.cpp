#include "thesis/figures.hpp"

#include <cmath>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/formatted.hpp"
#include "configuration/rest.hpp"
#include "linear/step_response.hpp"

namespace servohil::thesis {
namespace {

using nlohmann::ordered_json;

/// x3, v3, P3, P4 over time, from the step on.
struct Response {
  std::vector<double> t_s;
  std::array<std::vector<double>, 4> states;
};

constexpr std::array kColumns = {"x3_in", "v3_in_s", "p3_psi", "p4_psi"};
constexpr std::array kLabels = {"x3 [in]", "dx3/dt [in/s]", "P3 [psi]", "P4 [psi]"};

int Samples(double end_s) {
  return static_cast<int>(std::lround(end_s / model::kTickS));
}

/// The program of Appendix D: (3.17) with the full derivative of the capillary.
Response Linear(const Case& c) {
  const linear::LinearSystem system =
      linear::ThesisSystem(c.Coefficients({.full_a4 = true, .simulation = true}));
  linear::StepResponse step(system, model::kTickS);
  Response r;
  const model::StateVector rest = c.rest.state.Vector();
  for (int i = 0; i <= Samples(kWindowS); ++i) {
    r.t_s.push_back(i * model::kTickS);
    for (std::size_t s = 0; s < r.states.size(); ++s) {
      const auto row = static_cast<Eigen::Index>(s);
      r.states[s].push_back(rest[row] + kStepPsi * step.Now()[row]);
    }
    step.Advance();
  }
  return r;
}

Response Nonlinear(const Case& c, double end_s) {
  simulation::Simulation simulation(c.model, c.rest);
  Response r;
  for (int i = 0; i <= Samples(end_s); ++i) {
    if (i > 0) simulation.Tick(c.rest.p1_psi + kStepPsi);
    const model::StateVector y = simulation.Now().state.Vector();
    r.t_s.push_back(i * model::kTickS);
    for (std::size_t s = 0; s < r.states.size(); ++s) r.states[s].push_back(y[static_cast<Eigen::Index>(s)]);
  }
  return r;
}

/// Collects figures; each is a CSV file with a column per curve's axis.
class Folder {
 public:
  explicit Folder(std::filesystem::path path) : path_(std::move(path)) {
    std::error_code error;
    std::filesystem::create_directories(path_, error);
    if (error) throw base::EnvironmentError(path_.string() + ": " + error.message());
  }

  struct Curve {
    std::string x, y, label;
  };
  struct Figure {
    std::string name;  ///< "figure_06"
    std::string caption;
    std::string x_label, y_label;
    std::vector<Curve> curves;
  };

  void Add(const Figure& figure, const std::vector<std::string>& columns,
           const std::vector<const std::vector<double>*>& values, const std::vector<std::string>& settings) {
    const std::filesystem::path file = path_ / (figure.name + ".csv");
    std::ofstream out(file);
    for (std::size_t i = 0; i < columns.size(); ++i) out << (i > 0 ? "," : "") << columns[i];
    out << '\n';
    for (std::size_t row = 0; row < values.front()->size(); ++row) {
      for (std::size_t i = 0; i < values.size(); ++i) {
        out << base::Formatted("%s%.10g", i > 0 ? "," : "", (*values[i])[row]);
      }
      out << '\n';
    }
    if (!out.flush()) throw base::EnvironmentError(file.string() + ": cannot be written");
    ordered_json curves = ordered_json::array();
    for (const Curve& c : figure.curves) curves.push_back({{"x", c.x}, {"y", c.y}, {"label", c.label}});
    index_.push_back({{"name", figure.name},
                      {"caption", figure.caption},
                      {"x_label", figure.x_label},
                      {"y_label", figure.y_label},
                      {"settings", settings},
                      {"curves", curves}});
  }

  /// One state of a response.
  void AddResponse(const std::string& name, const std::string& caption, const Response& r, std::size_t state,
                   const std::vector<std::string>& settings) {
    Add({name, caption, "Time [s]", kLabels.at(state), {{"t_s", kColumns.at(state), ""}}},
        {"t_s", kColumns.at(state)}, {&r.t_s, &r.states.at(state)}, settings);
  }

  void Finish() const {
    std::ofstream out(path_ / "figures.json");
    out << index_.dump(1) << '\n';
    if (!out.flush()) throw base::EnvironmentError((path_ / "figures.json").string() + ": cannot be written");
  }

 private:
  std::filesystem::path path_;
  ordered_json index_ = ordered_json::array();
};

std::string Name(int number) {
  return (number < 10 ? "figure_0" : "figure_") + std::to_string(number);
}

/// Which states of a row the thesis shows, under which numbers.
struct Shown {
  int number;
  std::size_t state;
  const char* remark = "";  ///< on the caption
};
struct ShownRow {
  std::size_t row;
  std::vector<Shown> figures;
};

constexpr const char* kDot =
    "; the caption prints x3, as that of the figure before it; the text speaks of both";
constexpr const char* kNoDot = "; the caption prints the derivative, its pair is Figure ";

std::string Caption(const Shown& shown, const char* study, const std::string& what) {
  return "Figure " + std::to_string(shown.number) + ". " + study + " " + kLabels.at(shown.state) + " for " +
         what + shown.remark;
}

std::string Describe(const Row& row) {
  return base::Formatted("U = %g in, c_r1 = c_r2 = %g in, beta = %g psi, alpha = %g, F_CF = %g psi",
                         row.underlap_in, row.clearance_in, row.bulk_modulus_psi, row.alpha, row.coulomb_psi);
}

void LoadAndCam(const MakeCase& make, Folder& folder) {
  const Case b = make({});
  const Case a = make({.two_slope_cam = true});
  std::vector<double> x3, p_load, p1_a, p1_b;
  for (int i = 100; i <= 800; ++i) {
    x3.push_back(0.01 * i);
    p_load.push_back(b.derived.load_up.PressureAt(x3.back()));
    p1_a.push_back(configuration::RequireSteadyStateAt(a.derived, x3.back()).p1_psi);
    p1_b.push_back(configuration::RequireSteadyStateAt(b.derived, x3.back()).p1_psi);
  }
  folder.Add({"figure_03",
              "Figure 3. External Load as a Function of Piston Displacement",
              "x3 [in]",
              "P3 at rest [psi]",
              {{"x3_in", "p3_psi", ""}}},
             {"x3_in", "p3_psi"}, {&x3, &p_load}, b.settings);
  folder.Add({"figure_04",
              "Figure 4. Main Piston Displacement as a Function of Input Control Oil Pressure",
              "P1 [psi]",
              "x3 [in]",
              {{"p1_a_psi", "x3_in", "Curve A, two slopes"}, {"p1_b_psi", "x3_in", "Curve B, one slope"}}},
             {"x3_in", "p1_a_psi", "p1_b_psi"}, {&x3, &p1_a, &p1_b}, b.settings);
}

}  // namespace

void WriteFigures(const MakeCase& make, const std::filesystem::path& path) {
  Folder folder(path);
  LoadAndCam(make, folder);
  const std::vector<ShownRow> linear = {
      {0, {{6, 0}, {7, 1}, {8, 2}, {9, 3}}}, {1, {{10, 0}}}, {2, {{11, 0}}}, {3, {{12, 0}}}};
  for (const auto& [row, figures] : linear) {
    const Case c = make(TableIII()[row]);
    const Response r = Linear(c);
    const std::string what = Describe(TableIII()[row]) + " (clearances in the steady state only)";
    for (const Shown& f : figures)
      folder.AddResponse(Name(f.number), Caption(f, "Linearized Analysis.", what), r, f.state, c.settings);
  }
  const std::vector<ShownRow> uncompensated = {{0, {{14, 0}, {15, 1}, {16, 2}, {17, 3}}},
                                               {1, {{18, 0}}},
                                               {2, {{19, 0}, {20, 1, kDot}, {21, 2}}},
                                               {3, {{22, 0}, {23, 1, kDot}}},
                                               {4, {{24, 0}, {25, 1}}},
                                               {5, {{26, 0}, {27, 1}, {28, 2}}},
                                               {6, {{29, 0}, {30, 1}, {31, 2}}}};
  for (const auto& [row, figures] : uncompensated) {
    const Case c = make(TableIV()[row]);
    const Response r = Nonlinear(c, kWindowS);
    const std::string what = Describe(TableIV()[row]);
    for (const Shown& f : figures)
      folder.AddResponse(Name(f.number), Caption(f, "Nonlinear Study of Uncompensated System.", what), r,
                         f.state, c.settings);
    if (figures.front().number == 18) {
      const Shown longer{18, 0, "; over 1 s: past the thesis' 0.1 s it grows to a limit cycle (errata 19)"};
      folder.AddResponse("figure_18_1s", Caption(longer, "Nonlinear Study of Uncompensated System.", what),
                         Nonlinear(c, 1.0), 0, c.settings);
    }
  }
  for (std::size_t i = 0; i < TableVII().size(); ++i) {
    const Row row = CompensatedRow(TableVII()[i]);
    const Case c = make(row);
    const Response r = Nonlinear(c, kWindowS);
    constexpr std::array kTau = {"5.0", "0.90", "0.39", "0.05 (R C = 0.115, errata 17)", "0.023"};
    const std::string what =
        base::Formatted("tau_p = %s s: d7 = %g in, L7 = %g in, V_a = %g in3", kTau.at(i),
                        row.stabilizer->d7_in, row.stabilizer->l7_in, row.stabilizer->va_in3);
    const int number = 33 + 2 * static_cast<int>(i);
    const bool misprint = number == 35 || number == 37;
    const std::string remark = misprint ? kNoDot + std::to_string(number + 1) : "";
    folder.AddResponse(Name(number),
                       Caption({number, 0, remark.c_str()}, "Nonlinear Study of Compensated System.", what),
                       r, 0, c.settings);
    folder.AddResponse(Name(number + 1),
                       Caption({number + 1, 1}, "Nonlinear Study of Compensated System.", what), r, 1,
                       c.settings);
  }
  folder.Finish();
}

}  // namespace servohil::thesis
