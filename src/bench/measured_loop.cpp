#include "bench/measured_loop.hpp"

#include <atomic>
#include <memory>
#include "model/ticks.hpp"

#include "base/clock.hpp"
#include "rt/periodic_loop.hpp"

namespace servohil::bench {
namespace {

std::int64_t Ns(double seconds) noexcept {
  return static_cast<std::int64_t>(seconds * 1e9);
}

std::uint64_t LateWakes(const rt::LoopTiming& timing) noexcept {
  return timing.late.Count();
}

bool Holds(int wake_ticks, const rt::LoopTiming& timing) noexcept {
  return LateWakes(timing) == 0 && HoldsWithMargin(wake_ticks, timing.worst_lateness_ns,
                                                   static_cast<std::int64_t>(timing.compute.MaxNs()));
}

/// P1 of a servomotor that is never quite at rest: a step of 0.27 psi (the source's) up and down each 0.1 s.
double P1At(std::uint64_t tick, double rest_p1_psi) noexcept {
  constexpr double kStepPsi = 0.27;
  return rest_p1_psi + (tick / 1'000 % 2 == 0 ? kStepPsi : -kStepPsi);
}

}  // namespace

Level RunLevel(simulation::Simulation& simulation, double rest_p1_psi, int wake_ticks, double duration_s,
               double enough_s) {
  const auto loop = std::make_unique<rt::PeriodicLoop>(wake_ticks * model::kTickNs);
  const std::atomic<bool> stop{false};
  const std::int64_t begin_ns = base::MonotonicNs();
  loop->Run(stop, [&](const rt::LoopTiming& timing) noexcept {
    for (int i = 0; i < wake_ticks; ++i) simulation.Tick(P1At(simulation.Now().tick, rest_p1_psi));
    const std::int64_t elapsed_ns = base::MonotonicNs() - begin_ns;
    return elapsed_ns < Ns(Holds(wake_ticks, timing) ? duration_s : enough_s);
  });
  const rt::LoopTiming& timing = loop->Timing();
  return {
      .wake_ticks = wake_ticks,
      .holds = Holds(wake_ticks, timing),
      .measured_s = static_cast<double>(base::MonotonicNs() - begin_ns) / 1e9,
      .wakes = timing.wakes,
      .late_wakes = LateWakes(timing),
      .worst_lateness_ns = timing.worst_lateness_ns,
      .latency_median_ns = timing.wake_latency.QuantileNs(0.5),
      .latency_p999_ns = timing.wake_latency.QuantileNs(0.999),
      .compute_median_ns = timing.compute.QuantileNs(0.5),
      .compute_worst_ns = timing.compute.MaxNs(),
  };
}

}  // namespace servohil::bench
