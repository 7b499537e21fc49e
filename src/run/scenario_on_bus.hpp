#pragma once
/// A scenario on a bus: faults at their ticks, expectations held against every tick; the governor commands.

#include <cstdint>

#include "control/requests.hpp"
#include "emulator/emulator.hpp"
#include "run/scenario_options.hpp"
#include "scenario/evaluator.hpp"

namespace servohil::run {

class ScenarioOnBus {
 public:
  ScenarioOnBus(const scenario::ScenarioFile& file, const fault_words::Permissions& permissions,
                emulator::Clock clock);

  void AddTo(emulator::TaskOptions& task);

  /// After the run. @return exit status
  int Report(const ScenarioOptions& options, const emulator::Emulator& emulator, std::uint64_t lost_frames,
             bool recording_complete);

 private:
  const scenario::Scenario scenario_;
  scenario::Evaluator evaluator_;
};

}  // namespace servohil::run
