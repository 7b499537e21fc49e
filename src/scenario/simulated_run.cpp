#include "scenario/simulated_run.hpp"

namespace servohil::scenario {
namespace {

/// No bus is disturbed: only the configuration may forbid it.
fault_words::Permissions PermissionsOf(const configuration::Configuration& configuration) {
  fault_words::FaultContext context;
  context.surroundings.unfaulted = &configuration.model;
  context.surroundings.has_bus = false;
  context.surroundings.real_time = false;
  return {context, configuration.fault.armed != configuration::Armed::kNo,
          "faults are not armed: fault.armed = \"no\""};
}

}  // namespace

SimulatedRun::SimulatedRun(const ScenarioFile& file, const configuration::Configuration& configuration,
                           const model::SteadyState& start)
    : scenario_(file.Understand(PermissionsOf(configuration))),
      course_(scenario_.commands, start.p1_psi),
      evaluation_(scenario_) {}

void SimulatedRun::AddTo(emulator::TaskOptions& options) const {
  options.is_scenario = true;
  options.duration_ticks = scenario_.duration_ticks;
  options.wait_ticks = 1;  // the first command is there before the first tick
  options.script = scenario_.faults;
}

void SimulatedRun::Command(emulator::SimulationTask& task) {
  const double p1_psi = course_.At(task.Now().sample.tick);
  if (p1_psi == p1_psi_) return;
  p1_psi_ = p1_psi;
  task.PutRequest({.kind = simulation::Request::Kind::kCommand, .p1_psi = p1_psi});
}

void SimulatedRun::Take(emulator::SimulationTask& task) {
  evaluation_.Take(task.Now());
  Command(task);
}

Verdict SimulatedRun::Judge(const emulator::SimulationTask& task) const {
  return evaluation_.Judge(task.ScriptRefused() > 0
                               ? std::vector<std::string>{"faults were refused: too many at once"}
                               : std::vector<std::string>{});
}

}  // namespace servohil::scenario
