#pragma once
/// A scenario without bus and clock: it commands, and it looks at each tick.

#include "emulator/simulation_task.hpp"
#include "model/steady_state.hpp"
#include "scenario/command_course.hpp"
#include "scenario/evaluation.hpp"
#include "scenario/reader.hpp"

namespace servohil::scenario {

class SimulatedRun {
 public:
  /// @throws UsageError as ScenarioFile
  SimulatedRun(const ScenarioFile& file, const configuration::Configuration& configuration,
               const model::SteadyState& start);
  SimulatedRun(const SimulatedRun&) = delete;
  SimulatedRun& operator=(const SimulatedRun&) = delete;

  void AddTo(emulator::TaskOptions& options) const;
  /// Before the first tick: its command.
  void Command(emulator::SimulationTask& task);
  /// After each tick: looks at it, and gives the command of the next.
  void Take(emulator::SimulationTask& task);
  Verdict Judge(const emulator::SimulationTask& task) const;
  const Scenario& What() const { return scenario_; }

 private:
  const Scenario scenario_;
  CommandCourse course_;
  Evaluation evaluation_;
  double p1_psi_ = -1.0;  ///< of the newest command; none yet
};

}  // namespace servohil::scenario
