#pragma once
/// What the log is told of command frames that were refused, and of those that never came: the first at once,
/// what follows together, ever more rarely while it goes on.

#include <cstdint>
#include <string>

#include "simulation/safety.hpp"

namespace servohil::run {

class FrameLog {
 public:
  /// @param counts  since the start @return the line to log; empty: nothing new, or its time has not come
  std::string Look(const simulation::FrameCounts& counts, std::int64_t now_ns);
  /// At the end: whatever was not told.
  std::string Rest(const simulation::FrameCounts& counts) const;

 private:
  simulation::FrameCounts told_;
  std::int64_t not_before_ns_ = 0;
  std::int64_t pause_ns_ = 0;
};

}  // namespace servohil::run
