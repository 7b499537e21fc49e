#pragma once
/// A modelled bus in simulated time, for lockstep: when a command has passed it, and in which order an
/// answer.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "can/bus_model.hpp"
#include "signal_map/signal_map.hpp"

namespace servohil::emulator {

/// One thread.
class LockstepBus {
 public:
  /// @param signal_map  must outlive it
  LockstepBus(const signal_map::SignalMap& signal_map, const can::BusModelSettings& settings);

  /// A frame of others begins to wait after `tick`.
  void Offer(const can::Frame& frame, std::uint64_t tick);
  /// Every message begins to wait after `tick`.
  void OfferAnswer(std::uint64_t tick);
  /// The next frame of others that has passed by the end of `tick`, and the tick within which it did.
  struct Passed {
    can::Frame frame;
    std::uint64_t tick;
  };
  std::optional<Passed> Next(std::uint64_t tick);

  /// The messages as they pass when all wait at once: the lowest identifier first.
  const std::vector<std::size_t>& Order() const noexcept { return order_; }
  const can::BusModelStatistics& Statistics() const noexcept { return model_.Statistics(); }

 private:
  std::vector<can::Frame> answer_;  ///< identifiers and lengths are all that counts
  std::vector<std::size_t> order_;
  can::BusModel model_;
};

}  // namespace servohil::emulator
