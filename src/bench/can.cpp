#include "bench/can.hpp"

#include <algorithm>
#include <charconv>

#include "can/socketcan/interface_state.hpp"

namespace servohil::bench {
namespace {

/// An interface of the kernel as /sys/class/net shows it.
struct Interface {
  std::string name;
  bool is_can = false;
  bool up = false;
  bool is_virtual = false;  ///< vcan, vxcan, slcand: no bit rate, no queue to speak of
  long queue_length = 0;    ///< frames
};

unsigned long Number(const std::string& text, int base) {
  const std::size_t skipped = base == 16 && text.rfind("0x", 0) == 0 ? 2 : 0;
  unsigned long number = 0;
  std::from_chars(text.data() + skipped, text.data() + text.size(), number, base);
  return number;
}

Interface Look(const SystemFiles& files, const std::string& name) {
  constexpr unsigned long kTypeCan = 280;  // ARPHRD_CAN
  constexpr unsigned long kFlagUp = 1;     // IFF_UP
  const std::string folder = "sys/class/net/" + name;
  const auto number = [&](const char* file, int base) {
    return Number(files.Read(folder + file).value_or("0"), base);
  };
  Interface found{name};
  found.is_can = number("/type", 10) == kTypeCan;
  found.up = (number("/flags", 16) & kFlagUp) != 0;
  found.is_virtual = files.LinkTarget(folder).find("/virtual/") != std::string::npos;
  found.queue_length = static_cast<long>(number("/tx_queue_len", 10));
  return found;
}

std::string SetUp(const Interface& interface, int bit_rate_bit_s) {
  if (interface.is_virtual) return "sudo ip link set up " + interface.name;
  return "sudo ip link set " + interface.name + " up type can bitrate " + std::to_string(bit_rate_bit_s);
}

Finding Missing(const std::string& name, const configuration::CanSettings& can) {
  if (name.rfind("vcan", 0) == 0)
    return {"CAN", Grade::kBad, name + " is not there",
            "sudo ip link add dev " + name + " type vcan && sudo ip link set up " + name};
  return {"CAN", Grade::kBad, name + " is not there",
          "ip -brief link show type can  # lists those that are; then --set 'can.buses=[\"socketcan:NAME\"]' "
          "and " +
              SetUp({name}, can.bit_rate_bit_s)};
}

/// Room for the four messages that one tick may publish; and not so much that stale frames wait in it: 100 of
/// them take 25 ms at 500 kbit/s, more than two cycles of the fastest message.
bool IsQueueReasonable(long frames) {
  return frames >= 4 && frames <= 100;
}

Finding JudgeController(const Interface& interface, const configuration::CanSettings& can,
                        const Controller& controller) {
  const std::string set = "sudo ip link set " + interface.name;
  const auto has = [&](const char* word) { return controller.state.find(word) != std::string::npos; };
  const std::string value = interface.name + ": " + controller.state + ", queue of " +
                            std::to_string(interface.queue_length) + " frames";
  if (controller.bit_rate_bit_s &&
      *controller.bit_rate_bit_s != static_cast<std::uint32_t>(can.bit_rate_bit_s))
    return {"CAN", Grade::kBad, value + "; can.bit_rate_bit_s = " + std::to_string(can.bit_rate_bit_s),
            set + " down && " + SetUp(interface, can.bit_rate_bit_s)};
  if (has("bus-off"))
    return {"CAN", Grade::kBad, value, set + " type can restart  # once the wiring is mended"};
  if (has("error-warning") || has("error-passive"))
    return {"CAN", Grade::kWarn, value + ": frames are lost or unanswered; cable, termination, bit rates?",
            "ip -details -statistics link show " + interface.name};
  if (!IsQueueReasonable(interface.queue_length))
    return {"CAN", Grade::kWarn, value + "; 4 to 100 are reasonable", set + " txqueuelen 10"};
  return {"CAN", Grade::kOk, value, ""};
}

Finding CheckInterface(const SystemFiles& files, const std::string& name,
                       const configuration::CanSettings& can, const AskController& ask) {
  const Interface interface = Look(files, name);
  if (!files.Exists("sys/class/net/" + name)) return Missing(name, can);
  if (!interface.is_can)
    return {"CAN", Grade::kBad, name + " is not a CAN interface", "ip -brief link show type can"};
  if (!interface.up) return {"CAN", Grade::kBad, name + " is down", SetUp(interface, can.bit_rate_bit_s)};
  if (interface.is_virtual) return {"CAN", Grade::kOk, name + ": up, virtual", ""};
  return JudgeController(interface, can, ask(name));
}

Finding CheckSerial(const SystemFiles& files, const std::string& device) {
  if (!files.Exists(device.substr(1))) {
    return {"CAN", Grade::kBad, device + " is not there", "ls /dev/ttyACM* /dev/ttyUSB*  # those that are"};
  }
  if (!files.IsReadableAndWritable(device.substr(1)))
    return {"CAN", Grade::kBad, device + " is not readable and writable",
            "sudo usermod -a -G dialout $USER  # then log in again"};
  return {"CAN", Grade::kOk, device + ": readable and writable", ""};
}

Finding NotAllowed(const std::string& name, const std::string& what_a_run_does) {
  return {"CAN", Grade::kBad,
          name + " is a physical bus and can.allow_physical = false: a run " + what_a_run_does,
          "--set can.allow_physical=true  # if servohil may command what is on it"};
}

Finding CheckAutomatic(const SystemFiles& files, const configuration::CanSettings& can,
                       const AskController& ask) {
  std::string refused;
  for (const std::string& name : can.interfaces) {
    if (!Look(files, name).is_can) continue;
    if (can.allow_physical || !ask(name).physical) return CheckInterface(files, name, can, ask);
    if (refused.empty()) refused = name;
  }
  if (!refused.empty()) {
    Finding finding = NotAllowed(refused, "would use slcan:pty");
    finding.grade = Grade::kWarn;
    finding.value = "auto: " + finding.value;
    return finding;
  }
  const Finding first = Missing(can.interfaces.empty() ? "can0" : can.interfaces.front(), can);
  return {"CAN", Grade::kWarn, "auto: " + first.value + "; a run would use slcan:pty", first.fix};
}

}  // namespace

Controller AskKernel(const std::string& interface) {
  return {can::InterfaceBitRate(interface), !can::IsVirtualInterface(interface),
          can::DescribeInterface(interface)};
}

Findings CheckBuses(const SystemFiles& files, const configuration::CanSettings& can,
                    const AskController& ask) {
  constexpr std::string_view kKernel = "socketcan:";
  constexpr std::string_view kSerial = "slcan:/";
  Findings findings;
  for (const std::string& url : can.buses) {
    if (url == "auto") {
      findings.push_back(CheckAutomatic(files, can, ask));
    } else if (url.rfind(kKernel, 0) == 0) {
      const std::string name = url.substr(kKernel.size());
      findings.push_back(CheckInterface(files, name, can, ask));
      if (!can.allow_physical && Look(files, name).is_can && ask(name).physical)
        findings.push_back(NotAllowed(name, "refuses it"));
    } else if (url.rfind(kSerial, 0) == 0) {
      const std::string device = url.substr(kSerial.size() - 1);
      findings.push_back(CheckSerial(files, device));
      if (!can.allow_physical && files.Exists(device.substr(1)) && !can::IsTerminalOfAProgram(device))
        findings.push_back(NotAllowed(device, "refuses it"));
    } else if (url == "slcan:pty" || url.rfind("slcan:pty:", 0) == 0) {
      findings.push_back({"CAN", Grade::kOk, url + ": needs no interface", ""});
    } else {
      findings.push_back({"CAN", Grade::kBad, url + " is not a bus",
                          "--set 'can.buses=[\"socketcan:can0\"]', slcan:pty, slcan:/dev/TTY or auto"});
    }
  }
  return findings;
}

}  // namespace servohil::bench
