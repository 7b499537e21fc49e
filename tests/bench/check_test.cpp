/// `servohil check` on made-up machines: each property with its verdict and the command that mends it.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "bench/can.hpp"
#include "bench/cpu.hpp"
#include "bench/kernel.hpp"
#include "bench/limits.hpp"
#include "bench/measurement.hpp"
#include "bench/verdict.hpp"
#include "support/default_setup.hpp"

namespace servohil::bench {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kHighResolutionNs = 1;
constexpr std::int64_t kJiffyNs = 4'000'000;  // CONFIG_HZ=250

Finding Of(const Findings& findings, const std::string& name) {
  for (const Finding& finding : findings) {
    if (finding.name == name) return finding;
  }
  ADD_FAILURE() << "no finding named " << name;
  return {};
}

bool Has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// A bench as it should be: PREEMPT_RT, CPU 3 of 4 isolated and to the loop alone, can0 at 500 kbit/s. Each
/// test spoils one thing.
class Check : public ::testing::Test {
 protected:
  Check() {
    Write("proc/version", "Linux version 6.1.0-18-rt-amd64 (gcc) #1 SMP PREEMPT_RT Debian 6.1.76-1");
    Write("proc/sys/kernel/osrelease", "6.1.0-18-rt-amd64");
    Write("proc/sys/kernel/sched_rt_runtime_us", "-1");
    Write("proc/sys/kernel/sched_rt_period_us", "1000000");
    Write("proc/cpuinfo", "processor\t: 0\nflags\t\t: fpu vme tsc\n");
    Write("proc/loadavg", "0.30 0.20 0.10 1/200 1000");
    Write("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc");
    Write("proc/self/status", "Name:\tservohil\nCapEff:\t0000000000804000\n");  // CAP_SYS_NICE, CAP_IPC_LOCK
    Write("proc/self/limits", kLimits);
    Write(kCpus + "online", "0-3");
    Write(kCpus + "isolated", "3");
    Write(kCpus + "nohz_full", "2-3");
    for (const char* cpu : {"cpu0", "cpu1", "cpu2", "cpu3"})
      Write(kCpus + cpu + "/cpufreq/scaling_governor", "performance");
    Write(kCpus + "cpu3/cpuidle/state0/name", "POLL");
    Write(kCpus + "cpu3/cpuidle/state0/latency", "0");
    AddInterrupt("24", "eth0", "0-2");
    AddInterface("can0", "devices/pci0000:00/0000:00:14.0/usb1/net/can0", 280, true);
  }
  ~Check() override { fs::remove_all(root_); }

  void Write(const fs::path& path, const std::string& text) {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text << '\n';
  }
  void AddInterrupt(const std::string& number, const std::string& handler, const std::string& cpus) {
    Write("proc/irq/" + number + "/smp_affinity_list", cpus);
    if (!handler.empty()) fs::create_directories(root_ / "proc/irq" / number / handler);
  }
  void AddInterface(const std::string& name, const fs::path& device, int type, bool up) {
    const fs::path folder = fs::path("sys") / device;
    Write(folder / "type", std::to_string(type));
    Write(folder / "flags", up ? "0x400c1" : "0x400c0");
    Write(folder / "tx_queue_len", "10");
    fs::create_directories(root_ / "sys/class/net");
    fs::remove(root_ / "sys/class/net" / name);
    fs::create_directory_symlink(fs::path("../../") / device, root_ / "sys/class/net" / name);
  }
  void Remove(const fs::path& path) { fs::remove_all(root_ / path); }

  Findings Kernel(std::int64_t resolution_ns = kHighResolutionNs) const {
    return CheckKernel(files_, resolution_ns);
  }
  Findings Cpu(int loop_cpu = 3) const { return CheckCpu(files_, loop_cpu); }
  Finding Can(const std::string& url = "socketcan:can0", bool allow_physical = true) const {
    return Cans(url, allow_physical).at(0);
  }
  Findings Cans(const std::string& url, bool allow_physical) const {
    configuration::CanSettings can;
    can.buses = {url};
    can.allow_physical = allow_physical;
    return CheckBuses(files_, can, [this](const std::string&) { return controller_; });
  }

  static constexpr const char* kLimits =
      "Limit                     Soft Limit           Hard Limit           Units\n"
      "Max locked memory         8388608              8388608              bytes\n"
      "Max realtime priority     0                    0\n";
  const std::string kCpus = "sys/devices/system/cpu/";
  const fs::path root_ = fs::path(::testing::TempDir()) / ("check_" + std::to_string(getpid()));
  const SystemFiles files_{root_};
  Controller controller_{500'000, true, "up, 500000 bit/s, error-active"};
};

TEST_F(Check, FindsNothingWrongWithABenchAsItShouldBe) {
  Findings all = Kernel();
  for (const Findings& some : {CheckLimits(files_, 80), Cpu(), Findings{Can()}})
    all.insert(all.end(), some.begin(), some.end());
  EXPECT_EQ(all.size(), 13U);
  for (const Finding& finding : all) {
    EXPECT_EQ(finding.grade, Grade::kOk) << finding.name << ": " << finding.value;
    EXPECT_EQ(finding.fix, "") << finding.name;
    EXPECT_NE(finding.value, "") << finding.name;
  }
}

TEST_F(Check, Kernel) {
  EXPECT_EQ(Of(Kernel(), "kernel").value, "6.1.0-18-rt-amd64, PREEMPT_RT");
  Write("proc/version", "Linux version 6.1.0-18-amd64 (gcc) #1 SMP PREEMPT_DYNAMIC Debian 6.1.76-1");
  const Finding dynamic = Of(Kernel(), "kernel");
  EXPECT_EQ(dynamic.grade, Grade::kWarn);
  EXPECT_TRUE(Has(dynamic.value, "PREEMPT_DYNAMIC, not PREEMPT_RT"));
  EXPECT_EQ(dynamic.fix, "sudo apt install linux-image-rt-amd64 && sudo reboot");
}

TEST_F(Check, Timers) {
  const Finding coarse = Of(Kernel(kJiffyNs), "timers");
  EXPECT_EQ(coarse.grade, Grade::kBad) << "0.1 ms cannot be slept in jiffies of 4 ms";
  EXPECT_TRUE(Has(coarse.value, "4000000 ns"));
  Write("proc/timer_list", "cpu: 0\n  .hres_active    : 0\n");
  EXPECT_EQ(Of(Kernel(), "timers").grade, Grade::kBad);
}

TEST_F(Check, ClockThatIsSlowToRead) {
  Write("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet");
  const Finding clock = Of(Kernel(), "clock");
  EXPECT_EQ(clock.grade, Grade::kWarn);
  EXPECT_TRUE(Has(clock.fix, "echo tsc | sudo tee"));
}

TEST_F(Check, Throttling) {
  Write("proc/sys/kernel/sched_rt_runtime_us", "950000");
  const Finding throttled = Of(Kernel(), "throttling");
  EXPECT_EQ(throttled.grade, Grade::kWarn);
  EXPECT_EQ(throttled.value, "real-time threads get 950000 of every 1000000 us");
  EXPECT_EQ(throttled.fix, "sudo sysctl -w kernel.sched_rt_runtime_us=-1");
  Write("proc/sys/kernel/sched_rt_runtime_us", "0");
  EXPECT_EQ(Of(Kernel(), "throttling").grade, Grade::kBad);
}

TEST_F(Check, VirtualMachine) {
  Write("proc/cpuinfo", "processor\t: 0\nflags\t\t: fpu vme hypervisor tsc\n");
  Write("sys/class/dmi/id/product_name", "KVM");
  const Finding machine = Of(Kernel(), "machine");
  EXPECT_EQ(machine.grade, Grade::kWarn);
  EXPECT_TRUE(Has(machine.value, "KVM"));
}

TEST_F(Check, UserModeLinux) {
  EXPECT_FALSE(IsUserModeLinux(files_));
  Write("proc/cpuinfo", "processor\t: 0\nvendor_id\t: User Mode Linux\n");
  EXPECT_TRUE(IsUserModeLinux(files_));
}

TEST_F(Check, Load) {
  Write("proc/loadavg", "2.10 1.00 1.00 1/200 1000");
  EXPECT_EQ(Of(Kernel(), "load").grade, Grade::kWarn) << "more than half of 4 CPUs";
  Write("proc/loadavg", "1.90 9.00 9.00 1/200 1000");
  EXPECT_EQ(Of(Kernel(), "load").grade, Grade::kOk);
}

TEST_F(Check, LimitsWithoutCapabilities) {
  Write("proc/self/status", "Name:\tservohil\nCapEff:\t0000000000000000\n");
  fs::create_symlink("/opt/servohil/bin/servohil", root_ / "proc/self/exe");
  for (const char* name : {"priority", "memory"}) {
    const Finding refused = Of(CheckLimits(files_, 80), name);
    EXPECT_EQ(refused.grade, Grade::kBad) << name;
    EXPECT_EQ(refused.fix, "sudo setcap cap_ipc_lock,cap_sys_nice=ep /opt/servohil/bin/servohil");
  }
  Write("proc/self/limits",
        "Max locked memory         unlimited            unlimited            bytes\n"
        "Max realtime priority     80                   99\n");
  for (const char* name : {"priority", "memory"})
    EXPECT_EQ(Of(CheckLimits(files_, 80), name).grade, Grade::kOk) << name;
  EXPECT_EQ(Of(CheckLimits(files_, 81), "priority").grade, Grade::kBad) << "the limit is 80";
}

TEST_F(Check, Isolation) {
  EXPECT_EQ(Of(Cpu(-1), "isolation").grade, Grade::kWarn);
  const Finding shared = Of(Cpu(1), "isolation");
  EXPECT_EQ(shared.grade, Grade::kWarn);
  EXPECT_TRUE(Has(shared.fix, "isolcpus=1 nohz_full=1"));
  const Finding absent = Of(Cpu(4), "isolation");
  EXPECT_EQ(absent.grade, Grade::kBad);
  EXPECT_EQ(absent.value, "loop.cpu = 4 is not there; online are 0-3");
  EXPECT_EQ(absent.fix, "--set loop.cpu=3");
  Write(kCpus + "nohz_full", "(null)");  // what the kernel writes when there is none
  const Finding ticking = Of(Cpu(), "isolation");
  EXPECT_EQ(ticking.grade, Grade::kWarn);
  EXPECT_TRUE(Has(ticking.fix, " nohz_full=3") && !Has(ticking.fix, "isolcpus")) << ticking.fix;
}

TEST_F(Check, Governor) {
  Write(kCpus + "cpu1/cpufreq/scaling_governor", "powersave");
  EXPECT_EQ(Of(Cpu(3), "governor").grade, Grade::kOk) << "not the loop's CPU";
  const Finding slow = Of(Cpu(-1), "governor");
  EXPECT_EQ(slow.grade, Grade::kWarn);
  EXPECT_EQ(slow.value, "powersave on CPU 1");
  EXPECT_EQ(slow.fix, "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor");
}

TEST_F(Check, IdleStates) {
  Write(kCpus + "cpu3/cpuidle/state1/name", "C6");
  Write(kCpus + "cpu3/cpuidle/state1/latency", "133");
  const Finding deep = Of(Cpu(), "idle states");
  EXPECT_EQ(deep.grade, Grade::kWarn);
  EXPECT_TRUE(Has(deep.value, "C6 takes 133 us to leave"));
  EXPECT_TRUE(Has(deep.fix, "cpuidle/state"));
  Write("dev/cpu_dma_latency", "");
  EXPECT_EQ(Of(Cpu(), "idle states").grade, Grade::kOk) << "a run holds it off";
  Remove("dev");
  Write(kCpus + "cpu3/cpuidle/state1/disable", "1");
  EXPECT_EQ(Of(Cpu(), "idle states").grade, Grade::kOk) << "switched off";
}

TEST_F(Check, Interrupts) {
  AddInterrupt("25", "nvme0q1", "0-3");
  AddInterrupt("130", "xhci_hcd", "3");
  AddInterrupt("26", "", "0-3");  // nothing uses it
  const Finding disturbed = Of(Cpu(), "interrupts");
  EXPECT_EQ(disturbed.grade, Grade::kWarn);
  EXPECT_EQ(disturbed.value, "on CPU 3: 25 nvme0q1, 130 xhci_hcd");
  EXPECT_EQ(disturbed.fix, "for i in 25 130; do echo 0-2 | sudo tee /proc/irq/$i/smp_affinity_list; done");
  for (const char* number : {"25", "130"})  // where they really go counts
    Write(std::string("proc/irq/") + number + "/effective_affinity_list", "0");
  EXPECT_EQ(Of(Cpu(), "interrupts").grade, Grade::kOk);
  EXPECT_EQ(Of(Cpu(-1), "interrupts").fix, "--set loop.cpu=3") << "on any CPU, there is always one";
}

TEST_F(Check, CanInterfaceThatIsNotThere) {
  const Finding can1 = Can("socketcan:can1");
  EXPECT_EQ(can1.grade, Grade::kBad);
  EXPECT_EQ(can1.value, "can1 is not there");
  const Finding vcan = Can("socketcan:vcan0");
  EXPECT_EQ(vcan.grade, Grade::kBad);
  EXPECT_EQ(vcan.fix, "sudo ip link add dev vcan0 type vcan && sudo ip link set up vcan0");
  EXPECT_EQ(Can("auto").value.rfind("can0: ", 0), 0U) << "the first of can.interfaces that is there";
  Remove("sys/class/net/can0");
  EXPECT_EQ(Can("auto").grade, Grade::kWarn) << "a run falls back to slcan:pty";
}

TEST_F(Check, CanInterfaceThatIsDownOrNoCan) {
  AddInterface("can0", "devices/pci0000:00/0000:00:14.0/usb1/net/can0", 280, false);
  const Finding down = Can();
  EXPECT_EQ(down.grade, Grade::kBad);
  EXPECT_EQ(down.fix, "sudo ip link set can0 up type can bitrate 500000");
  AddInterface("eth0", "devices/pci0000:00/net/eth0", 1, true);
  EXPECT_EQ(Can("socketcan:eth0").value, "eth0 is not a CAN interface");
  EXPECT_EQ(Can("socketcan:eth0").grade, Grade::kBad);
}

TEST_F(Check, CanController) {
  controller_ = {250'000, true, "up, 250000 bit/s, error-active"};
  EXPECT_EQ(Can().grade, Grade::kBad);
  EXPECT_EQ(Can().fix, "sudo ip link set can0 down && sudo ip link set can0 up type can bitrate 500000");
  controller_ = {500'000, true, "up, 500000 bit/s, bus-off"};
  EXPECT_EQ(Can().grade, Grade::kBad);
  EXPECT_TRUE(Has(Can().fix, "sudo ip link set can0 type can restart"));
  controller_ = {500'000, true, "up, 500000 bit/s, error-passive"};
  EXPECT_EQ(Can().grade, Grade::kWarn);
  controller_ = {500'000, true, "up, 500000 bit/s, error-active"};
  for (const char* frames : {"1", "1000"}) {
    Write("sys/devices/pci0000:00/0000:00:14.0/usb1/net/can0/tx_queue_len", frames);
    EXPECT_EQ(Can().grade, Grade::kWarn) << frames;
    EXPECT_EQ(Can().fix, "sudo ip link set can0 txqueuelen 10");
  }
}

TEST_F(Check, PhysicalBusThatARunMayNotUse) {
  controller_.physical = true;
  const Findings refused = Cans("socketcan:can0", false);
  ASSERT_EQ(refused.size(), 2U) << "its state, and that it may not be used";
  EXPECT_EQ(refused[1].grade, Grade::kBad);
  EXPECT_EQ(refused[1].value, "can0 is a physical bus and can.allow_physical = false: a run refuses it");
  EXPECT_TRUE(Has(refused[1].fix, "--set can.allow_physical=true"));
  EXPECT_EQ(Cans("socketcan:can0", true).size(), 1U);
  EXPECT_EQ(Can("auto", false).grade, Grade::kWarn);
  EXPECT_TRUE(Has(Can("auto", false).value, "a run would use slcan:pty"));
  AddInterface("vcan0", "devices/virtual/net/vcan0", 280, true);
  controller_.physical = false;
  EXPECT_EQ(Cans("socketcan:vcan0", false).size(), 1U);
  Write("dev/ttyACM0", "");
  EXPECT_EQ(Cans("slcan:/dev/ttyACM0", false).size(), 2U);
  EXPECT_EQ(Cans("slcan:/dev/ttyACM0", true).size(), 1U);
}

TEST_F(Check, OtherBuses) {
  AddInterface("vcan0", "devices/virtual/net/vcan0", 280, true);
  EXPECT_EQ(Can("socketcan:vcan0").value, "vcan0: up, virtual");
  EXPECT_EQ(Can("slcan:pty").grade, Grade::kOk);
  EXPECT_EQ(Can("slcan:/dev/ttyACM0").grade, Grade::kBad);
  Write("dev/ttyACM0", "");
  EXPECT_EQ(Can("slcan:/dev/ttyACM0").grade, Grade::kOk);
  EXPECT_EQ(Can("can0").grade, Grade::kBad) << "not a bus URL";
}

TEST(CheckCpuList, IsTheKernels) {
  EXPECT_EQ(ParseCpuList("0-3,8,10-11"), (std::vector<int>{0, 1, 2, 3, 8, 10, 11}));
  EXPECT_EQ(ParseCpuList(""), std::vector<int>{});
  EXPECT_EQ(CpuListText({0, 1, 2, 3, 8, 10, 11}), "0-3,8,10-11");
}

TEST(CheckRule, IsHalfTheWakePeriod) {
  EXPECT_TRUE(HoldsWithMargin(1, 40'000, 10'000));  // of 100 µs
  EXPECT_FALSE(HoldsWithMargin(1, 40'000, 10'001));
  EXPECT_TRUE(HoldsWithMargin(20, 990'000, 10'000));
}

Measurement WithLevels(const std::vector<std::pair<int, bool>>& levels) {
  Measurement measurement;
  for (const auto& [wake_ticks, holds] : levels) {
    Level level;
    level.wake_ticks = wake_ticks;
    level.holds = holds;
    measurement.levels.push_back(level);
  }
  return measurement;
}

TEST(CheckVerdict, IsFitAtTheNumberOfTicksThatHolds) {
  const Verdict best = Judge({}, WithLevels({{1, true}}), 1);
  EXPECT_EQ(best.text, "FIT at 0.1 ms");
  EXPECT_TRUE(best.as_configured);
  const Verdict better = Judge({}, WithLevels({{1, false}, {2, false}, {5, true}}), 10);
  EXPECT_EQ(better.text, "FIT at 5 ticks per wake");
  EXPECT_TRUE(better.as_configured);
  const Verdict worse = Judge({}, WithLevels({{1, false}, {2, false}, {5, true}}), 2);
  EXPECT_EQ(worse.text, "FIT at 5 ticks per wake, not at loop.wake_ticks = 2: --set loop.wake_ticks=5");
  EXPECT_FALSE(worse.as_configured);
}

TEST(CheckVerdict, IsUnfitWhenNothingHoldsOrSomethingIsBad) {
  const Verdict late = Judge({}, WithLevels({{1, false}, {50, false}}), 50);
  EXPECT_EQ(late.text, "UNFIT: ticks are late, or nearly so, at any number of ticks per wake");
  EXPECT_FALSE(late.as_configured);
  const Verdict bad =
      Judge({{"kernel", Grade::kWarn, "", ""}, {"CAN", Grade::kBad, "", ""}}, WithLevels({{1, true}}), 10);
  EXPECT_EQ(bad.text, "UNFIT: CAN; the loop alone holds at 0.1 ms");
  EXPECT_FALSE(bad.as_configured);
  EXPECT_EQ(bad.fit_wake_ticks, std::nullopt);
}

/// The rising search and its bookkeeping on this machine, whatever it is worth: levels in order, only the
/// last may hold, and `holds` is the rule applied to the figures beside it.
TEST(CheckMeasurement, RisesUntilOneHolds) {
  const testing::DefaultSetup setup({"loop.wake_ticks=30"});
  const Measurement measured = Measure(setup.configuration.model, setup.start, setup.configuration.loop, 0.5);
  const std::vector<int> expected = {1, 2, 5, 10, 20, 30, 50};
  ASSERT_FALSE(measured.levels.empty());
  EXPECT_GE(measured.load_threads, 1U);
  for (std::size_t i = 0; i < measured.levels.size(); ++i) {
    const Level& level = measured.levels[i];
    EXPECT_EQ(level.wake_ticks, expected.at(i));
    EXPECT_GE(level.wakes, 1U);
    EXPECT_EQ(level.holds,
              level.late_wakes == 0 && HoldsWithMargin(level.wake_ticks, level.worst_lateness_ns,
                                                       static_cast<std::int64_t>(level.compute_worst_ns)));
    if (i + 1 < measured.levels.size()) {
      EXPECT_FALSE(level.holds);
    }
  }
  EXPECT_TRUE(measured.levels.back().holds || measured.levels.size() == expected.size());
}

}  // namespace
}  // namespace servohil::bench
