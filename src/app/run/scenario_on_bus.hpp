#pragma once
/// A scenario on a bus: faults at their ticks, expectations held against every tick; the governor commands.

#include <cstdint>

#include "scenario_options.hpp"
#include "control/requests.hpp"
#include "scenario/evaluator.hpp"
#include "servohil/app/emulator.hpp"

namespace servohil::app {

class ScenarioOnBus {
 public:
  ScenarioOnBus(const scenario::ScenarioFile& file, const Permissions& permissions, Clock clock);

  void AddTo(TaskOptions& task);

  /// After the run. @return exit status
  int Report(const ScenarioOptions& options, const Emulator& emulator, std::uint64_t lost_frames,
             bool recording_complete);

 private:
  const scenario::Scenario scenario_;
  scenario::Evaluator evaluator_;
};

}  // namespace servohil::app
