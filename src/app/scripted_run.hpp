#pragma once
/// A run without bus and clock: commands from a list, ticks as fast as they go.

#include <span>

#include "p1_script.hpp"
#include "servohil/app/simulation_task.hpp"

namespace servohil::app {

/// Runs `task` until its duration is over, or `after_tick()` returns false; each change of P1 is a command
/// that arrives before its tick.
template <typename AfterTick>
void RunScript(SimulationTask& task, std::span<const P1Change> script, AfterTick&& after_tick) {
  std::size_t next = 0;
  for (bool goes_on = true; goes_on;) {
    // Of several commands before one tick the newest counts, as on a bus.
    while (next < script.size() && script[next].tick <= task.Now().sample.tick) {
      task.PutCommand({script[next].p1_psi});
      ++next;
    }
    goes_on = task.Run(1);
    goes_on = after_tick() && goes_on;
  }
}

}  // namespace servohil::app
