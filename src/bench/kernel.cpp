#include "bench/kernel.hpp"

#include <array>
#include <charconv>
#include <ctime>

#include "base/formatted.hpp"

namespace servohil::bench {
namespace {

Finding Preemption(const SystemFiles& files) {
  const std::string version = files.Read("proc/version").value_or("");
  const std::string release = files.Read("proc/sys/kernel/osrelease").value_or("unknown release");
  if (version.find("PREEMPT_RT") != std::string::npos || files.Read("sys/kernel/realtime") == "1")
    return {"kernel", Grade::kOk, release + ", PREEMPT_RT", ""};
  const char* preemption = "no preemption";
  for (const char* model : {"PREEMPT_DYNAMIC", "PREEMPT"}) {
    if (version.find(model) == std::string::npos) continue;
    preemption = model;
    break;
  }
  return {"kernel", Grade::kWarn, release + ", " + preemption + ", not PREEMPT_RT",
          "sudo apt install linux-image-rt-amd64 && sudo reboot"};
}

Finding Timers(const SystemFiles& files, std::int64_t resolution_ns) {
  constexpr std::int64_t kEnoughNs = 1'000;  // 1 % of a tick; with high-resolution timers it is 1
  const std::string value = base::Formatted("resolution %lld ns", static_cast<long long>(resolution_ns));
  // Only root may read the list; its absence says nothing.
  const std::string timer_list = files.Read("proc/timer_list").value_or("");
  const bool inactive = timer_list.find(".hres_active    : 0") != std::string::npos;
  if (resolution_ns <= kEnoughNs && !inactive) return {"timers", Grade::kOk, value, ""};
  return {"timers", Grade::kBad, value + ", high-resolution timers are off",
          "take highres=off from the kernel command line (/etc/default/grub, sudo update-grub, sudo reboot)"};
}

Finding ClockSource(const SystemFiles& files) {
  const std::string folder = "sys/devices/system/clocksource/clocksource0/";
  const std::string source = files.Read(folder + "current_clocksource").value_or("unknown");
  for (const char* slow : {"hpet", "acpi_pm", "jiffies", "refined-jiffies"}) {
    if (source == slow)
      return {"clock", Grade::kWarn, source + ", which takes a system call and a device access to read",
              "echo tsc | sudo tee /" + folder + "current_clocksource"};
  }
  return {"clock", Grade::kOk, source, ""};
}

Finding Throttling(const SystemFiles& files) {
  const std::string runtime = files.Read("proc/sys/kernel/sched_rt_runtime_us").value_or("-1");
  const std::string period = files.Read("proc/sys/kernel/sched_rt_period_us").value_or("1000000");
  const char* fix = "sudo sysctl -w kernel.sched_rt_runtime_us=-1";
  if (runtime == "-1" || runtime == period) return {"throttling", Grade::kOk, "off", ""};
  if (runtime == "0") return {"throttling", Grade::kBad, "no real-time thread may run at all", fix};
  return {"throttling", Grade::kWarn, "real-time threads get " + runtime + " of every " + period + " us",
          fix};
}

/// How a hypervisor shows, empty without one.
std::string Hypervisor(const SystemFiles& files) {
  if (const auto type = files.Read("sys/hypervisor/type")) return *type;
  if (files.Exists("proc/device-tree/hypervisor/compatible")) return "of the device tree";
  const std::string cpu = files.Read("proc/cpuinfo").value_or("");
  if (cpu.find(" hypervisor") == std::string::npos) return "";
  return files.Read("sys/class/dmi/id/product_name").value_or("of unknown name");
}

Finding VirtualMachine(const SystemFiles& files) {
  const std::string hypervisor = Hypervisor(files);
  if (hypervisor.empty()) return {"machine", Grade::kOk, "no hypervisor", ""};
  return {"machine", Grade::kWarn, "virtual, hypervisor " + hypervisor + ": its host may stop it at any time",
          ""};
}

Finding Load(const SystemFiles& files) {
  constexpr double kBusyShare = 0.5;  // of the CPUs: below, one is always free
  const std::string text = files.Read("proc/loadavg").value_or("0");
  double load = 0.0;
  std::from_chars(text.data(), text.data() + text.size(), load);
  const auto cpus = ParseCpuList(files.Read("sys/devices/system/cpu/online").value_or("0")).size();
  const std::string value = base::Formatted("%.2f on %zu CPUs over the last minute", load, cpus);
  if (load <= kBusyShare * static_cast<double>(cpus)) return {"load", Grade::kOk, value, ""};
  return {"load", Grade::kWarn, value + ": what else runs is measured, too",
          "ps -eo pcpu,pid,comm --sort=-pcpu | head"};
}

}  // namespace

bool IsUserModeLinux(const SystemFiles& files) {
  return files.Read("proc/cpuinfo").value_or("").find("User Mode Linux") != std::string::npos;
}

std::int64_t TimerResolutionNs() noexcept {
  timespec resolution{};
  clock_getres(CLOCK_MONOTONIC, &resolution);
  return resolution.tv_sec * 1'000'000'000LL + resolution.tv_nsec;
}

Findings CheckKernel(const SystemFiles& files, std::int64_t timer_resolution_ns) {
  return {Preemption(files),     Timers(files, timer_resolution_ns),
          ClockSource(files),    Throttling(files),
          VirtualMachine(files), Load(files)};
}

}  // namespace servohil::bench
