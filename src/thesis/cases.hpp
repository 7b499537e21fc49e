#pragma once
/// The parameter sets of the thesis' tables, as settings on top of the configuration.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "configuration/source.hpp"
#include "linear/thesis_linear.hpp"
#include "simulation/simulation.hpp"

namespace servohil::thesis {

inline constexpr double kX3In = 4.0;      ///< operating point of every result, section 3.5
inline constexpr double kStepPsi = 0.27;  ///< section 3.4
inline constexpr double kWindowS = 0.1;   ///< TMAX, ENDTIM: what the thesis integrated

/// A row of Table VII; V8 = V_a as in section 5.4.
struct Stabilizer {
  double d7_in;
  double l7_in;
  double va_in3;
};

/// What the tables vary; everything else is the configuration's.
struct Row {
  double underlap_in = 0.002;
  double clearance_in = 0.002;  ///< c_r1 = c_r2
  double bulk_modulus_psi = 110e3;
  double alpha = 0.32;
  double x3_star_in = 2.90;
  double coulomb_psi = 0.0;
  std::optional<Stabilizer> stabilizer = std::nullopt;
  bool two_slope_cam = false;
};

struct Case {
  std::vector<std::string> settings;    ///< "KEY=VALUE", what `--set` takes
  std::vector<std::string> parameters;  ///< every key of the model with its value
  model::Parameters model;
  model::Derived derived;
  model::SteadyState rest;

  linear::ThesisCoefficients Coefficients(const linear::ThesisLinearOptions& options = {}) const {
    return linear::ThesisCoefficientsAt(model, derived, rest, options);
  }
};

/// Makes a Case of a Row, on the configuration that the user chose.
using MakeCase = std::function<Case(const Row&)>;

/// @throws UsageError where a row has no steady state at 4.0 in
Case LoadCase(const configuration::ConfigurationOptions& base, const Row& row);

inline const std::vector<Row>& TableIII() {
  static const std::vector<Row> rows = {{.bulk_modulus_psi = 230e3},
                                        {.underlap_in = 0.001, .bulk_modulus_psi = 230e3},
                                        {},
                                        {.bulk_modulus_psi = 230e3, .alpha = 0.45, .x3_star_in = 3.38}};
  return rows;
}

inline const std::vector<Row>& TableIV() {
  static const std::vector<Row> rows = {
      {.clearance_in = 0.0, .bulk_modulus_psi = 230e3},
      {.underlap_in = 0.001, .clearance_in = 0.0, .bulk_modulus_psi = 230e3},
      {},
      {.underlap_in = 0.001, .clearance_in = 0.0},
      {.bulk_modulus_psi = 90e3},
      {.underlap_in = 0.001, .clearance_in = 0.0, .coulomb_psi = 5.0},
      {.alpha = 0.45, .x3_star_in = 3.38, .coulomb_psi = 5.0}};
  return rows;
}

inline const std::vector<Stabilizer>& TableV() {
  static const std::vector<Stabilizer> rows = {{0.05, 2.5, 20.0}, {0.15, 7.5, 98.0}, {0.30, 15.0, 100.0}};
  return rows;
}

inline const std::vector<Stabilizer>& TableVII() {
  static const std::vector<Stabilizer> rows = {
      {0.10, 8.2, 98.0}, {0.15, 7.5, 98.0}, {0.14, 12.0, 20.0}, {0.30, 15.0, 100.0}, {0.30, 15.0, 20.0}};
  return rows;
}

/// Table VII was simulated with the unstable set of Figures 22, 23.
inline Row CompensatedRow(const Stabilizer& stabilizer) {
  return {.underlap_in = 0.001, .clearance_in = 0.0, .stabilizer = stabilizer};
}

}  // namespace servohil::thesis
