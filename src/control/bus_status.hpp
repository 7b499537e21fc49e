#pragma once
/// The buses in the answer to "status".

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "can/bus_monitor.hpp"

namespace servohil::control {

nlohmann::json BusesToJson(const std::vector<can::BusReport>& buses);

}  // namespace servohil::control
