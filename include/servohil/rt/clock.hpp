#pragma once
/// CLOCK_MONOTONIC in nanoseconds, and sleeping until a point on it.

#include <cstdint>

namespace servohil::rt {

/// Real-time safe (vDSO).
std::int64_t MonotonicNs() noexcept;

/// Returns at once when the time has passed. The one system call of a real-time loop.
void SleepUntil(std::int64_t monotonic_ns) noexcept;

}  // namespace servohil::rt
