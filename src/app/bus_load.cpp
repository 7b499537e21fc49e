#include "servohil/app/contract.hpp"

namespace servohil::app {

std::vector<Contract::Load> Contract::BusLoad(int command_cycle_ms) const {
  const auto load = [](const can::Message& message, int cycle_ms) {
    const double bits = WorstCaseFrameBits(message.size_bytes, message.extended);
    return Load{message.name, cycle_ms, bits * 1000.0 / cycle_ms};
  };
  std::vector<Load> loads = {load(*command_, command_cycle_ms)};
  for (const Outgoing& outgoing : outgoing_) {
    loads.push_back(load(*outgoing.message, outgoing.cycle_ms));
  }
  return loads;
}

}  // namespace servohil::app
