#include "emulator/lockstep_bus.hpp"

#include <algorithm>
#include <numeric>

#include "can/frame_bits.hpp"
#include "model/ticks.hpp"

namespace servohil::emulator {
namespace {

std::int64_t NsOf(std::uint64_t tick) {
  return static_cast<std::int64_t>(tick) * model::kTickNs;
}

}  // namespace

LockstepBus::LockstepBus(const signal_map::SignalMap& signal_map, const can::BusModelSettings& settings)
    : order_(signal_map.MessageCount()), model_(settings) {
  for (std::size_t i = 0; i < signal_map.MessageCount(); ++i) answer_.push_back(signal_map.Encode(i, {}));
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
    return can::ArbitrationRank(answer_[a]) < can::ArbitrationRank(answer_[b]);
  });
}

void LockstepBus::Offer(const can::Frame& frame, std::uint64_t tick) {
  model_.Offer(frame, can::BusModel::From::kOthers, NsOf(tick));
}

void LockstepBus::OfferAnswer(std::uint64_t tick) {
  for (const can::Frame& frame : answer_) model_.Offer(frame, can::BusModel::From::kUs, NsOf(tick));
}

std::optional<LockstepBus::Passed> LockstepBus::Next(std::uint64_t tick) {
  while (const std::optional<can::BusModel::Passed> passed = model_.Next(NsOf(tick))) {
    if (passed->from == can::BusModel::From::kUs) continue;
    return Passed{passed->frame,
                  static_cast<std::uint64_t>((passed->end_ns + model::kTickNs - 1) / model::kTickNs)};
  }
  return std::nullopt;
}

}  // namespace servohil::emulator
