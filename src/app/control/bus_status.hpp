#pragma once
/// The buses in the answer to "status".

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "run/bus_watch.hpp"

namespace servohil::app::control {

nlohmann::json BusesToJson(const std::vector<BusReport>& buses);

}  // namespace servohil::app::control
