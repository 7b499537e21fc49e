#pragma once
/// What faults can be in this run, and whether anybody may inject them.

#include <vector>

#include "can/network.hpp"
#include "fault_words/permissions.hpp"
#include "run/run_options.hpp"

namespace servohil::run {

/// @param received  identifiers that are let in
fault_words::FaultContext FaultContextOf(const RunSetup& setup, const can::Network& network,
                                         const std::vector<can::WantedId>& received, emulator::Clock clock);

/// Faults belong on a bus that no real machine is on, unless the configuration says otherwise.
fault_words::Permissions PermissionsOf(const configuration::Configuration& configuration,
                                       const fault_words::FaultContext& context, const can::Network& network);

}  // namespace servohil::run
