#pragma once
/// A bus as it would be with wires: one frame at a time, as long as its worst-case bits take, the lowest
/// identifier of those that wait first. No clock: whoever asks says what time it is.
///
/// All that waits takes part in each arbitration, also several frames of one node: as with a controller that
/// sends the most important of its frames first, the model of Davis, Burns, Bril, Lukkien (frame_bits.hpp).
/// Frames of one identifier stay in their order. Nothing is ever disturbed or lost but by a full queue.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "can/frame.hpp"

namespace servohil::can {

struct BusModelSettings {
  std::uint32_t bit_rate_bit_s = 500'000;
  std::size_t queue_length = 16;  ///< frames of ours that may wait; one more is dropped, as the kernel does
};

/// Totals since the start. Trivially copyable.
struct BusModelStatistics {
  std::uint64_t frames = 0;          ///< that have begun to wait, of everybody
  std::uint64_t dropped = 0;         ///< of ours: the queue was full
  std::uint64_t missed_cycles = 0;   ///< of ours: the one before with the same identifier was still waiting
  std::uint64_t others_dropped = 0;  ///< more of the others' waited than the model holds
  std::int64_t worst_delay_ns = 0;   ///< of ours: from the offer to the end of the frame
  double worst_load = 0.0;           ///< asked of the bus in the worst 100 ms, as a share of what it carries
  /// The schedule would not have held on a real bus.
  bool Failed() const noexcept { return dropped + missed_cycles > 0; }
};

/// One thread at a time.
class BusModel {
 public:
  enum class From : std::uint8_t { kUs, kOthers };
  struct Passed {
    Frame frame;
    From from;
    std::int64_t offered_ns;
    std::int64_t end_ns;  ///< of the interframe space: the bus is free again
  };

  explicit BusModel(const BusModelSettings& settings);

  /// A frame waits for the bus from now on. Frames that are offered at one time take part in one arbitration.
  /// @param now_ns  never goes back @return false: dropped
  bool Offer(const Frame& frame, From from, std::int64_t now_ns);
  /// The next frame that has passed by `until_ns`, in order; nothing: no other has.
  /// After that, nothing may be offered for a time before `until_ns`.
  std::optional<Passed> Next(std::int64_t until_ns);
  /// When the next frame will have passed, if nothing more is offered; nothing: none waits.
  std::optional<std::int64_t> NextEnd() const noexcept;

  const BusModelStatistics& Statistics() const noexcept { return statistics_; }
  /// Longest time on the bus; of CAN FD all of it at the nominal bit rate, an upper bound.
  std::int64_t DurationNs(const Frame& frame) const noexcept;

 private:
  struct Waiting {
    Passed passed;
    std::uint32_t rank;
  };

  bool HasRoom(const Frame& frame, From from) noexcept;
  void Account(const Frame& frame, std::int64_t now_ns) noexcept;
  /// What happens strictly before `now_ns`.
  void AdvanceTo(std::int64_t now_ns);
  std::int64_t NextStart() const noexcept;
  std::vector<Waiting>::const_iterator WinnerAt(std::int64_t start_ns) const noexcept;

  BusModelSettings settings_;
  std::vector<Waiting> waiting_;      ///< in the order in which they were offered
  std::optional<Passed> on_the_bus_;  ///< its end is known
  std::deque<Passed> passed_;         ///< not taken yet
  std::int64_t free_from_ns_ = INT64_MIN;
  std::int64_t window_end_ns_ = INT64_MIN;  ///< of the load's
  std::int64_t asked_ns_ = 0;               ///< in this window
  BusModelStatistics statistics_;
};

}  // namespace servohil::can
