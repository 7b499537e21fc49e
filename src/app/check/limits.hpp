#pragma once
/// What this process may: real-time priority and locked memory, from its limits and capabilities.

#include "findings.hpp"
#include "system_files.hpp"

namespace servohil::app::check {

/// @param priority  loop.priority, 1 to 99
Findings CheckLimits(const SystemFiles& files, int priority);

}  // namespace servohil::app::check
