#pragma once
/// One fault of a run: what starts it, how it goes on, where it acts. Trivially copyable: it crosses threads,
/// and is part of snapshots and recordings. Time is in ticks of 0.1 ms.

#include <array>
#include <cstddef>
#include <cstdint>

namespace servohil::fault {

inline constexpr std::size_t kMaxParameters = 3;
using Values = std::array<double, kMaxParameters>;

/// What starts a fault.
struct Trigger {
  enum class Kind : std::uint8_t {
    kTime = 0,       ///< Injection::start_tick
    kCondition = 1,  ///< a quantity is beyond a threshold: at once if it is so already, else when it comes so
    kFrame = 2,      ///< a frame with this identifier is received
    kFault = 3,      ///< another fault begins to act, on whatever target
  };
  Kind kind = Kind::kTime;
  std::uint8_t quantity = 0;   ///< kCondition: its index among the emulator's quantities; of the truth
  bool above = true;           ///< kCondition: quantity > threshold; else <
  double threshold = 0.0;      ///< kCondition: in the quantity's unit
  std::uint32_t frame_id = 0;  ///< kFrame
  bool extended = false;       ///< kFrame: 29 bits
  std::uint8_t fault = 0;      ///< kFault: its number in the catalogue
};

/// A fault of the catalogue with its values and its time line: pulses, each of which rises from 0 to 1 in
/// `ramp_ticks`, and falls in `ramp_out_ticks` once it has lasted for `for_ticks`.
///
/// Without a period there is a pulse at each firing of the trigger, `times` of them: once a pulse is over,
/// the next firing starts another (a condition must have been false in between). With a period the first
/// firing starts a row of `times` pulses, the beginnings of which are `period_ticks` apart.
struct Injection {
  static constexpr std::uint8_t kEverything = 255;

  std::uint8_t id = 0;                ///< in the catalogue
  std::uint8_t target = kEverything;  ///< sensors: index of the quantity; sent frames: of the message, or all
  Values values{};
  std::uint64_t seed = 0;  ///< of what is random in it
  Trigger trigger;
  std::uint64_t start_tick = 0;  ///< kTime: first tick that has something of it; else no firing before
  std::uint64_t ramp_ticks = 0;
  std::uint64_t ramp_out_ticks = 0;
  std::uint64_t for_ticks = 0;     ///< of a pulse, from its start; 0: until cleared
  std::uint64_t period_ticks = 0;  ///< 0: none; else at least for_ticks + ramp_out_ticks
  std::uint32_t times = 1;         ///< 0: without end

  // What the run has made of it:
  bool waits = false;       ///< for its trigger; whoever injects one with a trigger other than kTime sets it
  bool was_true = false;    ///< kCondition: after the last tick
  std::uint32_t fired = 0;  ///< firings so far; start_tick is then that of the last one
  double held = 0.0;        ///< sensors: what was measured at the start of the pulse

  /// Share of the fault that acts during `tick`: 0 to 1. Real-time safe.
  double ShareAt(std::uint64_t tick) const noexcept;
  /// Since the beginning of its pulse. @pre it has begun
  std::uint64_t TicksSinceStart(std::uint64_t tick) const noexcept;
  /// Nothing of this firing acts at `tick` or later. Real-time safe.
  bool IsOverAt(std::uint64_t tick) const noexcept;
  /// `tick` is the first of a pulse. Real-time safe.
  bool StartsAt(std::uint64_t tick) const noexcept;
  /// The trigger has fired. Real-time safe.
  void Fire(std::uint64_t first_tick) noexcept;
  /// Another firing counts once this one is over.
  bool FiresAgain() const noexcept;
};

}  // namespace servohil::fault
