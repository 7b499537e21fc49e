#include "control/bus_status.hpp"

#include <nlohmann/json.hpp>

namespace servohil::control {

using Json = nlohmann::json;

Json BusesToJson(const std::vector<can::BusReport>& buses) {
  Json list = Json::array();
  for (const can::BusReport& bus : buses) {
    const can::BusCondition& is = bus.condition;
    Json faults = Json::array();
    for (std::size_t i = 0; i < can::kBusFaultCount; ++i) {
      const auto fault = static_cast<can::BusFault>(i);
      if (is.Has(fault)) faults.push_back(can::NameOf(fault));
    }
    list.push_back({{"bus", bus.name},
                    {"state", can::NameOf(is.state)},
                    {"faults", faults},
                    {"tx_errors", is.tx_errors},
                    {"rx_errors", is.rx_errors},
                    {"error_frames", is.error_frames},
                    {"not_sent", is.not_sent},
                    {"overruns", is.overruns},
                    {"conflicts", is.conflicts},
                    {"bus_offs", is.bus_offs}});
  }
  return list;
}

}  // namespace servohil::control
