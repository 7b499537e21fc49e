#pragma once
/// The kernel and the machine that it runs on: preemption, timers, real-time throttling, hypervisor, load.

#include <cstdint>

#include "bench/findings.hpp"
#include "bench/system_files.hpp"

namespace servohil::bench {

/// @param timer_resolution_ns  clock_getres(CLOCK_MONOTONIC)
Findings CheckKernel(const SystemFiles& files, std::int64_t timer_resolution_ns);

/// tools/vcan-guest, whose time is virtual: a loop measured there says nothing, and the load would stop its
/// time.
bool IsUserModeLinux(const SystemFiles& files);

/// clock_getres(CLOCK_MONOTONIC) of this machine: 1 with high-resolution timers, else a jiffy.
std::int64_t TimerResolutionNs() noexcept;

}  // namespace servohil::bench
