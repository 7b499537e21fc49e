#include "can/frame_bits.hpp"
#include "signal_map/signal_map.hpp"

namespace servohil::signal_map {

std::vector<SignalMap::Load> SignalMap::BusLoad() const {
  const auto load = [&](const can::Message& message, int cycle_ms) {
    const can::FrameBits bits = can::WorstCaseBits(message);
    return Load{message.name, cycle_ms, (bits.nominal + bits.data * data_rate_ratio_) * 1000.0 / cycle_ms};
  };
  std::vector<Load> loads;
  for (const ReceivedMessage& incoming : incoming_)
    loads.push_back(load(*incoming.message, incoming.cycle_ms));
  for (const PublishedMessage& outgoing : outgoing_)
    loads.push_back(load(*outgoing.message, outgoing.cycle_ms));
  return loads;
}

}  // namespace servohil::signal_map
