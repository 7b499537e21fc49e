#pragma once
/// A scenario without bus and clock: it commands, and it looks at each tick.

#include "command_course.hpp"
#include "evaluation.hpp"
#include "reader.hpp"
#include "servohil/app/simulation_task.hpp"
#include "servohil/model/steady_state.hpp"

namespace servohil::app::scenario {

class SimulatedRun {
 public:
  /// @throws UsageError as ScenarioFile
  SimulatedRun(const ScenarioFile& file, const Configuration& configuration, const model::SteadyState& start);
  SimulatedRun(const SimulatedRun&) = delete;
  SimulatedRun& operator=(const SimulatedRun&) = delete;

  void AddTo(TaskOptions& options) const;
  /// Before the first tick: its command.
  void Command(SimulationTask& task);
  /// After each tick: looks at it, and gives the command of the next.
  void Take(SimulationTask& task);
  Verdict Judge(const SimulationTask& task) const;
  const Scenario& What() const { return scenario_; }

 private:
  const Scenario scenario_;
  CommandCourse course_;
  Evaluation evaluation_;
  double p1_psi_ = -1.0;  ///< of the newest command; none yet
};

}  // namespace servohil::app::scenario
