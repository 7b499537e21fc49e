#include "run_options.hpp"

#include <algorithm>

#include "servohil/app/ticks.hpp"

namespace servohil::app {

TaskOptions TaskOptionsOf(const RunOptions& options, const LoopSettings& loop) {
  TaskOptions task;
  task.loop = loop;
  task.duration_ticks = TicksOf(options.duration_s);
  for (const double s : options.snapshot_at_s) task.snapshot_ticks.push_back(TicksOf(s));
  std::sort(task.snapshot_ticks.begin(), task.snapshot_ticks.end());
  return task;
}

}  // namespace servohil::app
