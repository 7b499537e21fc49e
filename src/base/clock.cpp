#include "base/clock.hpp"

#include <cerrno>
#include <ctime>

namespace servohil::base {
namespace {

std::int64_t NowNs(clockid_t clock) noexcept {
  timespec t{};
  clock_gettime(clock, &t);
  return std::int64_t{t.tv_sec} * kNsPerS + t.tv_nsec;
}

}  // namespace

std::int64_t MonotonicNs() noexcept {
  return NowNs(CLOCK_MONOTONIC);
}

std::int64_t RealTimeNs() noexcept {
  return NowNs(CLOCK_REALTIME);
}

void SleepUntil(std::int64_t monotonic_ns) noexcept {
  const timespec t{monotonic_ns / kNsPerS, monotonic_ns % kNsPerS};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

}  // namespace servohil::base
