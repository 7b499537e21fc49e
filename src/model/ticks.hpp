#pragma once
/// Between ticks and other units of time.

#include <cmath>
#include <cstdint>

#include "model/step.hpp"

namespace servohil::model {

inline constexpr std::int64_t kTickNs = 100'000;  ///< model::kTickS in nanoseconds
inline constexpr int kTicksPerMs = 10;

/// The nearest number of ticks. @pre seconds >= 0
inline std::uint64_t TicksOf(double seconds) {
  return static_cast<std::uint64_t>(std::llround(seconds / model::kTickS));
}

inline double SecondsOf(std::uint64_t ticks) {
  return static_cast<double>(ticks) * model::kTickS;
}

}  // namespace servohil::model
