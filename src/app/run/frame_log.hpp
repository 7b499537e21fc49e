#pragma once
/// What the log is told of command frames that were refused, and of those that never came: the first at once,
/// what follows together, ever more rarely while it goes on.

#include <cstdint>
#include <string>

#include "servohil/app/safety.hpp"

namespace servohil::app {

class FrameLog {
 public:
  /// @param counts  since the start @return the line to log; empty: nothing new, or its time has not come
  std::string Look(const FrameCounts& counts, std::int64_t now_ns);
  /// At the end: whatever was not told.
  std::string Rest(const FrameCounts& counts) const;

 private:
  FrameCounts told_;
  std::int64_t not_before_ns_ = 0;
  std::int64_t pause_ns_ = 0;
};

}  // namespace servohil::app
