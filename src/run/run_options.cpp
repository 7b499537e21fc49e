#include "run/run_options.hpp"

#include <algorithm>

#include "model/ticks.hpp"

namespace servohil::run {

emulator::TaskOptions TaskOptionsOf(const RunOptions& options, const configuration::LoopSettings& loop) {
  emulator::TaskOptions task;
  task.loop = loop;
  task.duration_ticks = model::TicksOf(options.duration_s);
  for (const double s : options.snapshot_at_s) task.snapshot_ticks.push_back(model::TicksOf(s));
  std::sort(task.snapshot_ticks.begin(), task.snapshot_ticks.end());
  return task;
}

}  // namespace servohil::run
