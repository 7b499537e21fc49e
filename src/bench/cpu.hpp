#pragma once
/// The loop's CPU: whether it is there, its isolation, frequency, idle states and interrupts.

#include "bench/findings.hpp"
#include "bench/system_files.hpp"

namespace servohil::bench {

/// @param loop_cpu  loop.cpu; -1: any
Findings CheckCpu(const SystemFiles& files, int loop_cpu);

}  // namespace servohil::bench
