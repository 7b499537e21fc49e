#pragma once
/// Everything `servohil linear` says about one operating point.

#include <optional>
#include <string>
#include <vector>

#include "configuration/configuration.hpp"
#include "linear/linearization.hpp"
#include "linear/margins.hpp"
#include "linear/step_response.hpp"
#include "linear/thesis_linear.hpp"

namespace servohil::linear {

enum class LinearModel : std::uint8_t { kNonlinear, kThesis };

struct LinearOptions {
  LinearModel model = LinearModel::kNonlinear;
  ThesisLinearOptions thesis;
  std::optional<double> x3_in;
  std::optional<double> p1_psi;
};

struct LinearPoint {
  model::SteadyState rest;
  std::vector<std::string> states;  ///< "x3_in", in the order of the system
  LinearSystem system;
  std::optional<double> jacobian_relative_error;  ///< nonlinear model only
  std::vector<std::string> notes;                 ///< what a reader must know to use the numbers
};

/// @throws UsageError where there is no steady state
LinearPoint LinearPointOf(const model::Parameters& parameters, const LinearOptions& options);

struct LinearAnalysis {
  LinearPoint point;
  TransferFunction transfer;  ///< x3/P1 [in/psi]; thesis model: as (B.18), (G.15) scale it
  PoleList poles;
  RouthArray routh;
  TransferFunction loop;
  Margins margins;
  StepFigures step;
};

LinearAnalysis Analyse(const model::Parameters& parameters, const LinearOptions& options);

void PrintText(const LinearAnalysis& analysis);
void PrintJson(const LinearAnalysis& analysis);

/// CSV of the stability over two keys, "KEY=LOW:HIGH[:N]" each, to `output`.
void WriteMap(const std::filesystem::path& configuration, const std::vector<std::string>& settings,
              const std::vector<std::string>& axes, const LinearOptions& options, const std::string& output);

}  // namespace servohil::linear
