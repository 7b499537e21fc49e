#include "bench/cpu.hpp"

#include <algorithm>
#include <charconv>

namespace servohil::bench {
namespace {

const std::string kCpus = "sys/devices/system/cpu/";

bool Contains(const std::vector<int>& cpus, int cpu) {
  return std::find(cpus.begin(), cpus.end(), cpu) != cpus.end();
}

std::vector<int> CpuList(const SystemFiles& files, const std::string& path) {
  return ParseCpuList(files.Read(path).value_or(""));
}

std::string FolderOf(int cpu) {
  return kCpus + "cpu" + std::to_string(cpu) + "/";
}

/// CPUs that the loop may run on.
std::vector<int> LoopCpus(const SystemFiles& files, int loop_cpu) {
  if (loop_cpu >= 0) return {loop_cpu};
  return CpuList(files, kCpus + "online");
}

/// The one that a loop would be given: CPU 0 has most of the kernel's own work.
std::string LastCpu(const SystemFiles& files) {
  const std::vector<int> online = CpuList(files, kCpus + "online");
  return std::to_string(online.empty() ? 0 : online.back());
}

Finding Isolation(const SystemFiles& files, int cpu) {
  const std::vector<int> online = CpuList(files, kCpus + "online");
  const std::string last = LastCpu(files);
  if (cpu < 0)
    return {"isolation", Grade::kWarn, "loop.cpu = -1: any CPU, shared with everything else",
            "kernel command line: isolcpus=" + last + " nohz_full=" + last + "; then --set loop.cpu=" + last};
  const std::string n = std::to_string(cpu);
  if (!Contains(online, cpu))
    return {"isolation", Grade::kBad, "loop.cpu = " + n + " is not there; online are " + CpuListText(online),
            "--set loop.cpu=" + last};
  const bool isolated = Contains(CpuList(files, kCpus + "isolated"), cpu) ||
                        Contains(CpuList(files, "sys/fs/cgroup/cpuset.cpus.isolated"), cpu);
  const bool tickless = Contains(CpuList(files, kCpus + "nohz_full"), cpu);
  if (isolated && tickless) return {"isolation", Grade::kOk, "CPU " + n + ": isolated, nohz_full", ""};
  std::string missing;
  if (!isolated) missing += " isolcpus=" + n;
  if (!tickless) missing += " nohz_full=" + n;
  return {"isolation", Grade::kWarn,
          "CPU " + n + (isolated ? ": isolated, but not nohz_full" : " is shared with other processes"),
          "kernel command line (/etc/default/grub, sudo update-grub, sudo reboot):" + missing};
}

Finding Governor(const SystemFiles& files, const std::vector<int>& cpus) {
  std::vector<int> slow;
  std::string governor;
  for (const int cpu : cpus) {
    const auto found = files.Read(FolderOf(cpu) + "cpufreq/scaling_governor");
    if (!found) continue;
    if (*found != "performance") slow.push_back(cpu);
    if (governor.empty() || *found != "performance") governor = *found;
  }
  if (governor.empty()) return {"governor", Grade::kOk, "the kernel does not scale the frequency", ""};
  if (slow.empty()) return {"governor", Grade::kOk, governor, ""};
  return {"governor", Grade::kWarn, governor + " on CPU " + CpuListText(slow),
          "echo performance | sudo tee /" + kCpus + "cpu*/cpufreq/scaling_governor"};
}

struct IdleState {
  std::string name;
  long exit_us = 0;  ///< time to leave it
};

long Number(const std::string& text) {
  long number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

/// The enabled one that takes longest to leave.
IdleState DeepestIdle(const SystemFiles& files, const std::vector<int>& cpus) {
  IdleState deepest;
  for (const int cpu : cpus) {
    const std::string folder = FolderOf(cpu) + "cpuidle/";
    for (const std::string& state : files.List(folder)) {
      if (files.Read(folder + state + "/disable").value_or("0") != "0") continue;
      const long exit_us = Number(files.Read(folder + state + "/latency").value_or("0"));
      if (exit_us <= deepest.exit_us) continue;
      deepest = {files.Read(folder + state + "/name").value_or(state), exit_us};
    }
  }
  return deepest;
}

Finding IdleStates(const SystemFiles& files, const std::vector<int>& cpus) {
  constexpr long kShortUs = 2;  // C1 of x86-64: less than the wake-up itself
  const IdleState deepest = DeepestIdle(files, cpus);
  if (deepest.exit_us <= kShortUs)
    return {"idle states", Grade::kOk, "none that takes more than 2 us to leave", ""};
  const std::string value = deepest.name + " takes " + std::to_string(deepest.exit_us) + " us to leave";
  if (files.IsReadableAndWritable("dev/cpu_dma_latency"))
    return {"idle states", Grade::kOk, value + "; held off during runs by /dev/cpu_dma_latency", ""};
  if (files.Exists("dev/cpu_dma_latency"))
    return {"idle states", Grade::kWarn, value + "; /dev/cpu_dma_latency is not readable and writable",
            "sudo chmod o+rw /dev/cpu_dma_latency"};
  return {"idle states", Grade::kWarn, value + "; there is no /dev/cpu_dma_latency to hold it off",
          "for d in /" + kCpus + "cpu*/cpuidle/state[1-9]/disable; do echo 1 | sudo tee $d; done"};
}

/// What the interrupt serves; empty when nothing does. The kernel gives each handler a folder.
std::string HandlerOf(const SystemFiles& files, const std::string& irq) {
  for (const std::string& name : files.List("proc/irq/" + irq)) {
    if (files.IsFolder("proc/irq/" + irq + "/" + name)) return name;
  }
  return {};
}

bool MayComeOn(const SystemFiles& files, const std::string& irq, int cpu) {
  const std::string folder = "proc/irq/" + irq + "/";
  const std::string effective = files.Read(folder + "effective_affinity_list").value_or("");
  return Contains(
      ParseCpuList(effective.empty() ? files.Read(folder + "smp_affinity_list").value_or("") : effective),
      cpu);
}

Finding Interrupts(const SystemFiles& files, int cpu) {
  if (cpu < 0)
    return {"interrupts", Grade::kWarn, "loop.cpu = -1: may come on the loop's CPU",
            "--set loop.cpu=" + LastCpu(files)};
  std::string numbers;
  std::string named;
  for (const std::string& irq : files.List("proc/irq")) {
    if (!MayComeOn(files, irq, cpu)) continue;
    const std::string handler = HandlerOf(files, irq);
    if (handler.empty()) continue;
    numbers += (numbers.empty() ? "" : " ") + irq;
    named += (named.empty() ? "" : ", ") + irq + " " + handler;
  }
  const std::string on = "CPU " + std::to_string(cpu);
  if (numbers.empty()) return {"interrupts", Grade::kOk, "no device's come on " + on, ""};
  std::vector<int> others = CpuList(files, kCpus + "online");
  others.erase(std::remove(others.begin(), others.end(), cpu), others.end());
  return {"interrupts", Grade::kWarn, "on " + on + ": " + named,
          others.empty() ? ""
                         : "for i in " + numbers + "; do echo " + CpuListText(others) +
                               " | sudo tee /proc/irq/$i/smp_affinity_list; done"};
}

}  // namespace

Findings CheckCpu(const SystemFiles& files, int loop_cpu) {
  const std::vector<int> cpus = LoopCpus(files, loop_cpu);
  return {Isolation(files, loop_cpu), Governor(files, cpus), IdleStates(files, cpus),
          Interrupts(files, loop_cpu)};
}

}  // namespace servohil::bench
