#pragma once
/// The buses in the answer to "status".

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "servohil/can/bus_monitor.hpp"

namespace servohil::app::control {

nlohmann::json BusesToJson(const std::vector<can::BusReport>& buses);

}  // namespace servohil::app::control
