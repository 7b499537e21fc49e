#include "bench/limits.hpp"

#include <charconv>
#include <cstdint>
#include <optional>
#include <sstream>

namespace servohil::bench {
namespace {

// linux/capability.h
constexpr unsigned kCapIpcLock = 14;
constexpr unsigned kCapSysNice = 23;

std::uint64_t EffectiveCapabilities(const SystemFiles& files) {
  const std::string status = files.Read("proc/self/status").value_or("");
  constexpr std::string_view kKey = "\nCapEff:\t";
  const std::size_t at = status.find(kKey);
  std::uint64_t capabilities = 0;
  if (at != std::string::npos)
    std::from_chars(status.data() + at + kKey.size(), status.data() + status.size(), capabilities, 16);
  return capabilities;
}

bool Has(std::uint64_t capabilities, unsigned which) {
  return (capabilities >> which & 1U) != 0;
}

/// Soft limit as /proc/self/limits writes it: a number or "unlimited"; "0" when it is not there.
std::string SoftLimit(const SystemFiles& files, const std::string& name) {
  std::istringstream lines(files.Read("proc/self/limits").value_or(""));
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(name, 0) != 0) continue;
    std::istringstream rest(line.substr(name.size()));
    std::string soft;
    rest >> soft;
    return soft;
  }
  return "0";
}

bool AtLeast(const std::string& limit, std::uint64_t wanted) {
  if (limit == "unlimited") return true;
  std::uint64_t number = 0;
  std::from_chars(limit.data(), limit.data() + limit.size(), number);
  return number >= wanted;
}

std::string SetCapabilities(const SystemFiles& files) {
  const std::string program = files.LinkTarget("proc/self/exe");
  return "sudo setcap cap_ipc_lock,cap_sys_nice=ep " + (program.empty() ? "servohil" : program);
}

Finding Priority(const SystemFiles& files, int priority) {
  const std::string limit = SoftLimit(files, "Max realtime priority");
  const std::string wanted = "SCHED_FIFO " + std::to_string(priority);
  if (Has(EffectiveCapabilities(files), kCapSysNice))
    return {"priority", Grade::kOk, wanted + " by CAP_SYS_NICE", ""};
  if (AtLeast(limit, static_cast<std::uint64_t>(priority)))
    return {"priority", Grade::kOk, wanted + " by RLIMIT_RTPRIO " + limit, ""};
  return {"priority", Grade::kBad, wanted + " is not permitted: RLIMIT_RTPRIO " + limit + ", no CAP_SYS_NICE",
          SetCapabilities(files)};
}

Finding LockedMemory(const SystemFiles& files) {
  // `run` maps 160 MiB, threads' stacks included (VmPeak on slcan:pty, x86-64), and locks all of it.
  constexpr std::uint64_t kEnoughBytes = std::uint64_t{256} << 20;
  const std::string limit = SoftLimit(files, "Max locked memory");
  if (Has(EffectiveCapabilities(files), kCapIpcLock))
    return {"memory", Grade::kOk, "may be locked by CAP_IPC_LOCK", ""};
  if (AtLeast(limit, kEnoughBytes))
    return {"memory", Grade::kOk, "may be locked by RLIMIT_MEMLOCK " + limit, ""};
  return {"memory", Grade::kBad, "cannot be locked: RLIMIT_MEMLOCK " + limit + " bytes, no CAP_IPC_LOCK",
          SetCapabilities(files)};
}

}  // namespace

Findings CheckLimits(const SystemFiles& files, int priority) {
  return {Priority(files, priority), LockedMemory(files)};
}

}  // namespace servohil::bench
