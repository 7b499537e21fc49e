#pragma once
/// A run without bus and clock: influences from a list, ticks as fast as they go.

#include <span>

#include "servohil/app/recording/recording.hpp"
#include "servohil/app/simulation_task.hpp"

namespace servohil::app {

/// Runs `task` until its duration is over, or `after_tick()` returns false; each influence is there before
/// its tick.
template <typename AfterTick>
void RunScript(SimulationTask& task, std::span<const Influence> script, AfterTick&& after_tick) {
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

}  // namespace servohil::app
