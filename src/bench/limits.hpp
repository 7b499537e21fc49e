#pragma once
/// What this process may: real-time priority and locked memory, from its limits and capabilities.

#include "bench/findings.hpp"
#include "bench/system_files.hpp"

namespace servohil::bench {

/// @param priority  loop.priority, 1 to 99
Findings CheckLimits(const SystemFiles& files, int priority);

}  // namespace servohil::bench
