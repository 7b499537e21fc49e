#pragma once
/// Everything `servohil linear` says about one operating point.

#include <optional>
#include <string>
#include <vector>

#include "servohil/app/configuration.hpp"
#include "servohil/model/linearization.hpp"
#include "servohil/model/margins.hpp"
#include "servohil/model/step_response.hpp"
#include "servohil/model/thesis_linear.hpp"

namespace servohil::app {

enum class LinearModel : std::uint8_t { kNonlinear, kThesis };

struct LinearOptions {
  LinearModel model = LinearModel::kNonlinear;
  model::ThesisLinearOptions thesis;
  std::optional<double> x3_in;
  std::optional<double> p1_psi;
};

struct LinearPoint {
  model::SteadyState rest;
  std::vector<std::string> states;  ///< "x3_in", in the order of the system
  model::LinearSystem system;
  std::optional<double> jacobian_relative_error;  ///< nonlinear model only
  std::vector<std::string> notes;                 ///< what a reader must know to use the numbers
};

/// @throws UsageError where there is no steady state
LinearPoint LinearPointOf(const model::Parameters& parameters, const LinearOptions& options);

struct LinearAnalysis {
  LinearPoint point;
  model::TransferFunction transfer;  ///< x3/P1 [in/psi]; thesis model: as (B.18), (G.15) scale it
  model::PoleList poles;
  model::RouthArray routh;
  model::TransferFunction loop;
  model::Margins margins;
  model::StepFigures step;
};

LinearAnalysis Analyse(const model::Parameters& parameters, const LinearOptions& options);

void PrintText(const LinearAnalysis& analysis);
void PrintJson(const LinearAnalysis& analysis);

/// CSV of the stability over two keys, "KEY=LOW:HIGH[:N]" each, to `output`.
void WriteMap(const std::filesystem::path& configuration, const std::vector<std::string>& settings,
              const std::vector<std::string>& axes, const LinearOptions& options, const std::string& output);

}  // namespace servohil::app
