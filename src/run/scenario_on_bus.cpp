#include "run/scenario_on_bus.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "run/report.hpp"

namespace servohil::run {

ScenarioOnBus::ScenarioOnBus(const scenario::ScenarioFile& file, const fault_words::Permissions& permissions,
                             emulator::Clock clock)
    : scenario_(file.Understand(permissions)), evaluator_(scenario_, clock != emulator::Clock::kReal) {
  if (!scenario_.commands.empty())
    spdlog::info("{}: the governor on the bus commands, not the scenario", scenario_.file.string());
}

void ScenarioOnBus::AddTo(emulator::TaskOptions& task) {
  task.is_scenario = true;
  task.duration_ticks = scenario_.duration_ticks;
  task.wait_ticks = scenario_.wait_ticks;
  task.script = scenario_.faults;
  task.feed = &evaluator_.Feed();
}

int ScenarioOnBus::Report(const ScenarioOptions& options, const emulator::Emulator& emulator,
                          std::uint64_t lost_frames, bool recording_complete) {
  // That the model left its domain is for the expectations to tell.
  simulation::RunState end = emulator.Final();
  end.sample.model_fault = false;
  std::vector<std::string> reasons = JudgeRun(end, lost_frames, emulator.ModelledBus()).reasons;
  if (!recording_complete) reasons.emplace_back("the recording is incomplete");
  if (emulator.ScriptRefused() > 0) reasons.emplace_back("faults were refused: too many at once");
  return options.Report(scenario_, evaluator_.Judge(std::move(reasons)));
}

}  // namespace servohil::run
