#pragma once
/// What faults can be in this run, and whether anybody may inject them.

#include <vector>

#include "permissions.hpp"
#include "run/run_options.hpp"
#include "servohil/can/network.hpp"

namespace servohil::app {

/// @param received  identifiers that are let in
FaultContext FaultContextOf(const RunSetup& setup, const can::Network& network,
                            const std::vector<can::WantedId>& received, Clock clock);

/// Faults belong on a bus that no real machine is on, unless the configuration says otherwise.
Permissions PermissionsOf(const Configuration& configuration, const FaultContext& context,
                                   const can::Network& network);

}  // namespace servohil::app
