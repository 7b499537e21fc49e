#pragma once

#include <chrono>
#include <cstdint>

namespace servohil::can {

/// CLOCK_REALTIME now, for frames that no kernel stamps.
inline std::int64_t RealTimeNs() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace servohil::can
