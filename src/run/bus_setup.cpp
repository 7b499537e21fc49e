#include "run/bus_setup.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cctype>

#include "base/error.hpp"
#include "base/formatted.hpp"
#include "can/socketcan/interface_state.hpp"
#include "run/bus_watch.hpp"

namespace servohil::run {

namespace {

std::string CycleKeys(const configuration::CanSettings& can) {
  return can.publish.empty() ? "publish.*_ms cycle times" : "cycle_ms of can.publish";
}

struct BusLoad {
  double share = 0.0;  ///< of the bit rate
  std::string text;
};

BusLoad BusLoadOf(const signal_map::SignalMap& signal_map, const configuration::CanSettings& can) {
  double bits_per_s = 0.0;
  std::string parts;
  for (const signal_map::SignalMap::Load& load : signal_map.BusLoad()) {
    bits_per_s += load.bits_per_s;
    parts += (parts.empty() ? "" : ", ") + load.message + " every " + std::to_string(load.cycle_ms) + " ms";
  }
  const int bit_rate_bit_s =
      can.emulate_bit_rate_bit_s != 0 ? can.emulate_bit_rate_bit_s : can.bit_rate_bit_s;
  const double share = bits_per_s / bit_rate_bit_s;
  return {share, base::Formatted("bus load at worst-case stuffing %.1f %% of %d bit/s: ", 100.0 * share,
                                 bit_rate_bit_s) +
                     parts};
}

}  // namespace

std::vector<std::string> WantedBuses(const std::vector<std::string>& asked,
                                     const configuration::Configuration& configuration) {
  const std::vector<std::string>& wanted = asked.empty() ? configuration.can.buses : asked;
  const std::string place = asked.empty() ? configuration.PlaceOf("can.buses") + ": can.buses: " : "";
  std::vector<std::string> mistakes;
  for (const std::string& url : wanted) {
    try {
      can::CheckUrl(url);
    } catch (const base::UsageError& error) {
      mistakes.push_back(place + error.what());
    }
  }
  if (!mistakes.empty()) throw base::UsageError(mistakes);
  return wanted;
}

std::vector<std::string> ResolveBuses(const std::vector<std::string>& wanted,
                                      const configuration::CanSettings& can) {
  std::vector<std::string> urls;
  for (const std::string& url : wanted) {
    if (url != "auto") {
      urls.push_back(url);
      continue;
    }
    urls.push_back(can::AutomaticUrl(can.interfaces, can.allow_physical));
    if (const std::string any = can::AutomaticUrl(can.interfaces); any != urls.back())
      spdlog::info("--can auto: {}", can::PhysicalRefusal(any));
    std::string looked_for;
    for (const std::string& interface : can.interfaces)
      looked_for += (looked_for.empty() ? "" : ", ") + interface;
    spdlog::info("--can auto: {} (looked for {})", urls.back(), looked_for);
  }
  return urls;
}

void RequireBusCarries(const signal_map::SignalMap& signal_map, const configuration::CanSettings& can) {
  const BusLoad load = BusLoadOf(signal_map, can);
  if (load.share > 1.0)
    throw base::UsageError(load.text + "; more than the bus carries: raise the " + CycleKeys(can));
}

void CheckBusLoad(const signal_map::SignalMap& signal_map, const configuration::CanSettings& can) {
  constexpr double kWarnAbove = 0.7;
  RequireBusCarries(signal_map, can);
  const BusLoad load = BusLoadOf(signal_map, can);
  if (load.share > kWarnAbove) {
    spdlog::warn("{}; above 70 % other nodes will wait: raise the {}", load.text, CycleKeys(can));
  } else {
    spdlog::info("{}", load.text);
  }
}

void ReportBuses(const can::Network& network, int bit_rate_bit_s) {
  for (const auto& bus : network.Buses()) {
    if (const std::string state = bus->State(); !state.empty()) spdlog::info("{}: {}", bus->Name(), state);
    const auto real = can::InterfaceBitRate(bus->Interface());
    if (real && *real != static_cast<std::uint32_t>(bit_rate_bit_s)) {
      spdlog::warn("{} runs at {} bit/s, can.bit_rate_bit_s = {}: the bus load above is wrong by that ratio",
                   bus->Name(), *real, bit_rate_bit_s);
    }
  }
}

can::BusOptions BusOptionsOf(const signal_map::SignalMap& signal_map,
                             const configuration::Configuration& configuration,
                             const emulator::EmulatorOptions& options) {
  can::BusOptions bus;
  bus.wanted = signal_map.Wanted();
  if (configuration.fault.allow_can)
    bus.wanted.push_back(emulator::FaultPort::RequestId(signal_map.Databases()));
  if (options.clock == emulator::Clock::kLockstep && options.lockstep.sync_id >= 0)
    bus.wanted.push_back({static_cast<std::uint32_t>(options.lockstep.sync_id), false});
  // What another node sends with an identifier of ours is to be seen, too.
  for (std::size_t i = 0; i < signal_map.MessageCount(); ++i)
    bus.wanted.push_back({signal_map.MessageOf(i).id, signal_map.MessageOf(i).extended});
  const configuration::CanSettings& can = configuration.can;
  bus.bit_rate_bit_s = static_cast<std::uint32_t>(can.bit_rate_bit_s);
  if (signal_map.UsesFd()) bus.data_bit_rate_bit_s = static_cast<std::uint32_t>(can.data_bit_rate_bit_s);
  bus.allow_physical = can.allow_physical;
  if (can.configure) bus.configure = LinkSettingsOf(can);
  if (can.emulate_bit_rate_bit_s == 0) return bus;
  bus.wanted.clear();  // everybody's frames take their time
  if (options.clock == emulator::Clock::kReal) bus.model = BusModelOf(can);
  return bus;
}

can::BusModelSettings BusModelOf(const configuration::CanSettings& can) {
  return {static_cast<std::uint32_t>(can.emulate_bit_rate_bit_s), static_cast<std::size_t>(can.queue_length)};
}

std::vector<std::string> BusNames(const can::Network& network) {
  std::vector<std::string> names;
  for (const auto& bus : network.Buses()) names.push_back(LogName(bus->Name(), names));
  return names;
}

std::string LogName(const std::string& bus, const std::vector<std::string>& taken) {
  constexpr std::size_t kLongest = 15;  // IFNAMSIZ - 1
  std::string name = bus.substr(bus.find(':') + 1);
  if (name.rfind("/dev/", 0) == 0) name = name.substr(5);
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isgraph(c) == 0; }, '_');
  while (name.size() > 1 && name.back() == '/') name.pop_back();
  if (name.size() > kLongest) name = name.substr(name.rfind('/') + 1);
  if (name.size() > kLongest) name = name.substr(name.size() - kLongest);
  const std::string stem = name;
  for (int i = 2; std::find(taken.begin(), taken.end(), name) != taken.end(); ++i) {
    const std::string end = "~" + std::to_string(i);
    name = stem.substr(0, kLongest - end.size()) + end;
  }
  return name;
}

}  // namespace servohil::run
