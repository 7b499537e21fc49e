#include "rt/process.hpp"

#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

namespace servohil::rt {
namespace {

std::string Reason(int error) {
  return std::generic_category().message(error);
}

}  // namespace

Shortcomings LockMemory() {
  mallopt(M_TRIM_THRESHOLD, -1);  // never give memory back: it would fault when it is needed again
  mallopt(M_MMAP_MAX, 0);
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return {};
  return {"memory is not locked (" + Reason(errno) +
          "): sudo setcap cap_ipc_lock,cap_sys_nice=ep <servohil>, or `memlock unlimited` in "
          "/etc/security/limits.d"};
}

Shortcomings MakeThreadRealTime(int priority, int cpu) {
  Shortcomings missing;
  if (cpu >= 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<std::size_t>(cpu), &set);
    const int error = pthread_setaffinity_np(pthread_self(), sizeof set, &set);
    if (error != 0) {
      missing.push_back("CPU " + std::to_string(cpu) + " cannot be used (" + Reason(error) +
                        "): `nproc --all` tells how many there are, `taskset -pc $$` which are allowed");
    }
  }
  sched_param parameters{};
  parameters.sched_priority = priority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  if (error != 0) {
    missing.push_back("no real-time priority " + std::to_string(priority) + " (" + Reason(error) +
                      "): sudo setcap cap_ipc_lock,cap_sys_nice=ep <servohil>, or `rtprio 99` in "
                      "/etc/security/limits.d");
  }
  return missing;
}

void PrefaultStack() noexcept {
  // Five times the deepest call chain: a tick that follows a fault builds the parameters anew in 45 KiB
  // (page faults of allocation_test's fault test over this size).
  constexpr std::size_t kStackBytes = std::size_t{256} * 1024;
  std::array<volatile unsigned char, kStackBytes> stack;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  for (std::size_t i = 0; i < kStackBytes; i += 1024) stack[i] = 0;
}

void NameThread(const char* name) noexcept {
  pthread_setname_np(pthread_self(), name);
}

long ThreadPageFaults() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt + usage.ru_majflt;
}

}  // namespace servohil::rt
