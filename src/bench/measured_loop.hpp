#pragma once
/// One run of the loop: the one place of `servohil check` that knows rt::PeriodicLoop.

#include "bench/measurement.hpp"
#include "simulation/simulation.hpp"

namespace servohil::bench {

/// Runs `simulation`, `wake_ticks` ticks a wake-up, on the calling thread for `duration_s`; where it does not
/// hold, for `enough_s`.
Level RunLevel(simulation::Simulation& simulation, double rest_p1_psi, int wake_ticks, double duration_s,
               double enough_s);

}  // namespace servohil::bench
