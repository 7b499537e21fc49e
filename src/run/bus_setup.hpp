#pragma once
/// From the configuration to the buses of a run.

#include <string>
#include <vector>

#include "can/network.hpp"
#include "configuration/configuration.hpp"
#include "emulator/emulator.hpp"
#include "signal_map/signal_map.hpp"

namespace servohil::run {

/// Those that are asked for, else those of the configuration.
/// @throws UsageError for URLs of no known form, a line for each, with the place where the configuration has
/// it
std::vector<std::string> WantedBuses(const std::vector<std::string>& asked,
                                     const configuration::Configuration& configuration);

/// "auto" replaced by what this machine has.
std::vector<std::string> ResolveBuses(const std::vector<std::string>& wanted,
                                      const configuration::CanSettings& can);

/// @throws UsageError where the frames of the run are more than the bus carries
void RequireBusCarries(const signal_map::SignalMap& signal_map, const configuration::CanSettings& can);
/// Logs the load of the bus; warns above 70 %. @throws UsageError above 100 %
void CheckBusLoad(const signal_map::SignalMap& signal_map, const configuration::CanSettings& can);

/// Logs the state of each bus that has one; warns where its bit rate is not the one that the load is for.
void ReportBuses(const can::Network& network, int bit_rate_bit_s);

/// What this run wants of its buses: identifiers, bit rate, model.
can::BusOptions BusOptionsOf(const signal_map::SignalMap& signal_map,
                             const configuration::Configuration& configuration,
                             const emulator::EmulatorOptions& options);

/// Of can.emulate_bitrate.
can::BusModelSettings BusModelOf(const configuration::CanSettings& can);

/// For bus.log: "vcan0", "pts/3".
std::vector<std::string> BusNames(const can::Network& network);

/// Returns the name of a bus in a candump log: one that can-utils take (at most 15 characters, none of them blank), and that
/// is not among those `taken`. "slcan:/dev/ttyACM0" is ttyACM0, "slcan:/tmp/bench-adapter" bench-adapter.
std::string LogName(const std::string& bus, const std::vector<std::string>& taken);

}  // namespace servohil::run
