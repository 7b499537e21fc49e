#pragma once
/// The clocks in nanoseconds, and sleeping until a point on the monotonic one.

#include <cstdint>

namespace servohil::base {

inline constexpr std::int64_t kNsPerS = 1'000'000'000;
inline constexpr std::int64_t kNsPerMs = 1'000'000;

/// CLOCK_MONOTONIC. Real-time safe (vDSO).
std::int64_t MonotonicNs() noexcept;

/// CLOCK_REALTIME, as the kernel stamps frames. Real-time safe (vDSO).
std::int64_t RealTimeNs() noexcept;

/// Returns at once when the time has passed. The one system call of a real-time loop.
void SleepUntil(std::int64_t monotonic_ns) noexcept;

}  // namespace servohil::base
