#include "bench/measurement.hpp"

#include <algorithm>
#include <set>
#include <thread>

#include "base/clock.hpp"
#include "bench/background_load.hpp"
#include "bench/measured_loop.hpp"
#include "rt/cpu_latency.hpp"

namespace servohil::bench {
namespace {

std::vector<Level> MeasureLevels(const model::Parameters& parameters, const model::SteadyState& start,
                                 int configured_ticks, double duration_s) {
  std::set<int> all = {1, 2, 5, 10, 20, 50};
  all.insert(configured_ticks);
  const double enough_s = duration_s / 12.0;
  const std::int64_t begin_ns = base::MonotonicNs();
  std::vector<Level> levels;
  for (const int wake_ticks : all) {
    const double left_s = duration_s - static_cast<double>(base::MonotonicNs() - begin_ns) / 1e9;
    const double share_s = wake_ticks == *all.rbegin() ? left_s : left_s / 2.0;
    simulation::Simulation simulation(parameters, start);
    levels.push_back(RunLevel(simulation, start.p1_psi, wake_ticks, share_s, std::min(share_s, enough_s)));
    if (levels.back().holds) break;
  }
  return levels;
}

}  // namespace

Measurement Measure(const model::Parameters& parameters, const model::SteadyState& start,
                    const configuration::LoopSettings& loop, double duration_s) {
  Measurement result;
  const BackgroundLoad load;
  result.load_threads = load.Threads();
  const rt::CpuLatencyHold
      hold;  // as a run does; check's finding on idle states says when it is not permitted
  std::thread measuring([&] {
    rt::NameThread("sim");
    result.missing = rt::LockMemory();
    for (const std::string& one : rt::MakeThreadRealTime(loop.priority, loop.cpu))
      result.missing.push_back(one);
    rt::PrefaultStack();
    result.levels = MeasureLevels(parameters, start, loop.wake_ticks, duration_s);
  });
  measuring.join();
  return result;
}

}  // namespace servohil::bench
