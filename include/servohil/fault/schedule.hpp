#pragma once
/// The faults of a run: which, from when to when, how strong now. Trivially copyable: part of a snapshot.

#include <array>
#include <cstddef>
#include <cstdint>

#include "servohil/fault/catalogue.hpp"
#include "servohil/model/parameters.hpp"

namespace servohil::fault {

/// One fault with its time line, in ticks of 0.1 ms: its share rises from 0 to 1 in `ramp_ticks` from
/// `start_tick` on, and falls again in as many once it has lasted for `for_ticks`.
struct Injection {
  std::uint8_t id = 0;
  Values values{};
  std::uint64_t start_tick = 0;  ///< first tick that has something of it
  std::uint64_t ramp_ticks = 0;  ///< in, and out again
  std::uint64_t for_ticks = 0;   ///< from start to end; 0: until cleared

  /// Share of the fault that acts during `tick`: 0 to 1. Real-time safe.
  double ShareAt(std::uint64_t tick) const noexcept;
  /// Nothing of it acts at `tick` or later. Real-time safe.
  bool IsOverAt(std::uint64_t tick) const noexcept;
};

class Schedule {
 public:
  static constexpr std::size_t kMostInjections = 16;

  /// Real-time safe. One of the same fault is replaced. @return false: there is no room
  bool Inject(const Injection& injection) noexcept;
  /// Real-time safe. @return how many there were
  std::size_t Clear(std::uint8_t id) noexcept;
  std::size_t ClearAll() noexcept;

  /// Drops what is over. @return whether the parameters of `tick` may differ from those of the tick before.
  /// Call once a tick. Real-time safe.
  bool Advance(std::uint64_t tick) noexcept;

  /// The parameters during `tick`: what acts then acts in the catalogue's order. Real-time safe.
  model::Parameters Faulted(const model::Parameters& unfaulted, std::uint64_t tick) const noexcept;

  /// Those that act or wait for their start, in the catalogue's order.
  const Injection* begin() const noexcept { return injections_.data(); }         // NOLINT: as in std
  const Injection* end() const noexcept { return injections_.data() + count_; }  // NOLINT: as in std
  std::size_t size() const noexcept { return count_; }                           // NOLINT: as in std
  /// How many act during `tick`. Real-time safe.
  std::size_t CountActive(std::uint64_t tick) const noexcept;

 private:
  void Remove(std::size_t index) noexcept;

  std::array<Injection, kMostInjections> injections_{};
  std::size_t count_ = 0;
  bool changed_ = false;  ///< since the last Advance()
};

}  // namespace servohil::fault
