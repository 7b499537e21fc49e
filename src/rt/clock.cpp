#include "servohil/rt/clock.hpp"

#include <cerrno>
#include <ctime>

namespace servohil::rt {
namespace {
constexpr std::int64_t kNsPerS = 1'000'000'000;
}

std::int64_t MonotonicNs() noexcept {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return std::int64_t{t.tv_sec} * kNsPerS + t.tv_nsec;
}

void SleepUntil(std::int64_t monotonic_ns) noexcept {
  const timespec t{monotonic_ns / kNsPerS, monotonic_ns % kNsPerS};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

}  // namespace servohil::rt
