/// Time of one tick. Goal: 250 ns with stabilizer and friction, 0.25 % of the 0.1 ms that it simulates.

#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>

#include "default_setup.hpp"

namespace servohil::app {
namespace {

void RunTicks(benchmark::State& state, const std::vector<std::string>& settings) {
  const testing::DefaultSetup setup(settings);
  Simulation simulation(setup.configuration.model, setup.start);
  // Always in motion, with reversals: 1 Hz, so that friction sticks and breaks away, too.
  double phase = 0.0;
  for (auto _ : state) {
    phase += 2.0 * std::numbers::pi * 1e-4;
    if (phase > 1e3) phase = 0.0;
    // A triangle instead of a sine, whose time would count as the tick's.
    const double triangle = std::fabs(std::fmod(phase, 2.0) - 1.0) - 0.5;
    benchmark::DoNotOptimize(simulation.Tick(setup.start.p1_psi + triangle));
  }
  if (simulation.Now().model_fault) state.SkipWithError("model fault");
  state.counters["percent_of_tick"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * model::kTickS * 1e-2,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

BENCHMARK_CAPTURE(RunTicks, plain, std::vector<std::string>{});
BENCHMARK_CAPTURE(RunTicks, friction, std::vector<std::string>{"friction.coulomb_psi=5"});
BENCHMARK_CAPTURE(RunTicks, stabilizer_and_friction,
                  std::vector<std::string>{"friction.coulomb_psi=5", "stabilizer.enabled=true"});

}  // namespace
}  // namespace servohil::app

BENCHMARK_MAIN();
