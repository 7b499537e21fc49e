#pragma once
/// How a bus is, by name.

#include <cstddef>
#include <cstdint>

namespace servohil::can {

/// The later, the worse.
enum class BusState : std::uint8_t {
  kErrorActive,   ///< as it should be; also of a virtual bus, which has no error states
  kErrorWarning,  ///< an error counter is at 96 or more
  kErrorPassive,  ///< at 128 or more
  kBusOff,        ///< the controller has left the bus
  kDown,          ///< the interface is down
  kGone,          ///< the interface, or the adapter's device, has been removed
};
const char* NameOf(BusState state) noexcept;

/// Faults that are seen now, or were within the last second.
enum class BusFault : std::uint8_t {
  kBitRateMismatch,  ///< nothing but disturbances: the others have another bit rate (or the wires are broken)
  kNoAcknowledge,    ///< nobody acknowledges: alone on the bus
  kQueueFull,        ///< frames find the transmit queue full, or those before them stuck in it
  kReceiveOverrun,   ///< frames were lost because they came faster than they were read
  kIdConflict,       ///< another node sends an identifier that is ours
};
inline constexpr std::size_t kBusFaultCount = 5;
const char* NameOf(BusFault fault) noexcept;

/// Trivially copyable.
struct BusCondition {
  BusState state = BusState::kErrorActive;
  std::uint8_t faults = 0;  ///< bit i: BusFault i
  std::uint8_t tx_errors = 0;
  std::uint8_t rx_errors = 0;
  // Totals since the start.
  std::uint64_t error_frames = 0;
  std::uint64_t not_sent = 0;  ///< full queue, or no bus
  std::uint64_t overruns = 0;  ///< frames lost before they were read
  std::uint64_t conflicts = 0;
  std::uint64_t bus_offs = 0;

  bool Has(BusFault fault) const noexcept { return (faults >> static_cast<unsigned>(fault) & 1U) != 0; }
  bool IsHealthy() const noexcept { return state == BusState::kErrorActive && faults == 0; }
  /// State and faults are the same.
  bool IsLike(const BusCondition& other) const noexcept {
    return state == other.state && faults == other.faults;
  }
};

/// Of several buses: the worst state, everybody's faults, the sums.
BusCondition Worst(const BusCondition& a, const BusCondition& b) noexcept;

}  // namespace servohil::can
