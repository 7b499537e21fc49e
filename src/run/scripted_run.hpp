#pragma once
/// A run without bus and clock: stimuli from a list, ticks as fast as they go.

#include <span>

#include "emulator/simulation_task.hpp"
#include "recording/recording.hpp"

namespace servohil::run {

/// Runs `task` until its duration is over, or `after_tick()` returns false; each stimulus is there before
/// its tick.
template <typename AfterTick>
void RunScript(emulator::SimulationTask& task, std::span<const recording::Stimulus> script,
               AfterTick&& after_tick) {
  std::size_t next = 0;
  for (bool goes_on = true; goes_on;) {
    while (next < script.size() && script[next].tick <= task.Now().sample.tick + 1) {
      task.PutRequest(script[next].request);
      task.ServeRequests();
      ++next;
    }
    goes_on = task.Run(1);
    goes_on = after_tick() && goes_on;
  }
}

}  // namespace servohil::run
