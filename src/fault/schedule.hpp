#pragma once
/// The faults of a run: which, from when to when, how strong now. Trivially copyable: part of a snapshot.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "fault/catalogue.hpp"
#include "fault/injection.hpp"
#include "model/parameters.hpp"

namespace servohil::fault {

/// Something that happened to a fault.
struct Event {
  enum class Kind : std::uint8_t {
    kWaits = 0,    ///< injected, with a start in the future or a trigger
    kStarts = 1,   ///< the first tick that has something of it, of each pulse
    kEnds = 2,     ///< the first tick that has nothing of it any more
    kChanged = 3,  ///< injected again: other values, another time line
    kCleared = 4
  };
  std::uint64_t tick = 0;
  Kind kind = Kind::kStarts;
  std::uint8_t id = 0;
  std::uint8_t target = Injection::kEverything;
  std::uint32_t pulse = 0;  ///< kStarts, kEnds: how many there were before it
};

class Schedule {
 public:
  static constexpr std::size_t kMaxInjections = 16;
  static constexpr std::size_t kMaxEvents = 64;

  /// One of the same fault and target is replaced. @param next_tick  the first that can feel it
  /// @return false: there is no room, or no such fault, or no target for a sensor fault. Real-time safe.
  bool Inject(const Injection& injection, std::uint64_t next_tick = 0) noexcept;
  /// Of this fault, on this target or (kEverything) on all. @return how many there were. Real-time safe.
  std::size_t Clear(std::uint8_t id, std::uint8_t target = Injection::kEverything,
                    std::uint64_t next_tick = 0) noexcept;
  std::size_t ClearAll(std::uint64_t next_tick = 0) noexcept;

  /// Drops what is over, starts what another fault's start has triggered. @return whether the parameters of
  /// `tick` may differ from those of the tick before. Call once a tick, before it. Real-time safe.
  bool Advance(std::uint64_t tick) noexcept;

  /// Whether Observe() has something to do. Real-time safe.
  bool Observes() const noexcept;
  /// After `tick`: conditions that have come true start their faults with the next one.
  /// @param truth  all quantities. Real-time safe.
  void Observe(std::uint64_t tick, std::span<const double> truth) noexcept;
  /// Some fault waits for this frame. Real-time safe.
  bool WaitsForFrame(std::uint32_t id, bool extended) const noexcept;
  /// The frame has come. Real-time safe.
  void TakeFrame(std::uint32_t id, bool extended, std::uint64_t next_tick) noexcept;

  /// The parameters during `tick`: what acts then acts in the catalogue's order. Real-time safe.
  model::Parameters Faulted(const model::Parameters& unfaulted, std::uint64_t tick) const noexcept;

  /// Those that act or wait for their start, in the catalogue's order.
  const Injection* begin() const noexcept { return injections_.data(); }         // NOLINT: as in std
  const Injection* end() const noexcept { return injections_.data() + count_; }  // NOLINT: as in std
  std::size_t size() const noexcept { return count_; }                           // NOLINT: as in std
  /// The same, for Sensors, which notes what they hold.
  std::span<Injection> All() noexcept { return {injections_.data(), count_}; }
  /// How many act during `tick`. Real-time safe.
  std::size_t CountActive(std::uint64_t tick) const noexcept;

  /// What has happened since ForgetEvents().
  std::span<const Event> Events() const noexcept { return {events_.data(), event_count_}; }
  void ForgetEvents() noexcept { event_count_ = 0; }

 private:
  void Remove(std::size_t index) noexcept;
  void Tell(Event::Kind kind, const Injection& injection, std::uint64_t tick) noexcept;
  void TellTransitions(std::uint64_t tick) noexcept;
  void FireOnFaults(std::uint64_t tick) noexcept;

  std::array<Injection, kMaxInjections> injections_{};
  std::size_t count_ = 0;
  bool changed_ = false;  ///< since the last Advance()
  std::array<Event, kMaxEvents> events_{};
  std::size_t event_count_ = 0;
};

}  // namespace servohil::fault
