#pragma once
/// What the faults of a schedule do to sensors, frames, wire and machine. Pure functions: of the schedule,
/// the tick and what they are asked about, so that the same seed gives the same fate in any thread.

#include <cstdint>
#include <span>

#include "fault/acts.hpp"
#include "fault/schedule.hpp"

namespace servohil::fault {

/// Whether any fault acts on frames that are published at `tick`. Real-time safe.
bool ActsOnPublished(const Schedule& schedule, std::uint64_t tick) noexcept;
/// Of the frame of a message that is published at `tick`. Real-time safe.
Transmission FateOfPublished(const Schedule& schedule, std::uint8_t message, std::uint64_t tick) noexcept;
/// Of the frame that arrives after `tick` as the `number`-th of the run. Real-time safe.
Reception FateOfArrived(const Schedule& schedule, std::uint64_t number, std::uint64_t tick) noexcept;
/// During `tick`. Real-time safe.
Line LineAt(const Schedule& schedule, std::uint64_t tick) noexcept;
/// Of the faults whose pulse begins with `tick`. Real-time safe.
Stall StallAt(const Schedule& schedule, std::uint64_t tick) noexcept;

/// Inverts `count` different bits, chosen by `key`; all where there are not more. Real-time safe.
void FlipBits(std::span<std::uint8_t> data, int count, std::uint64_t key) noexcept;

}  // namespace servohil::fault
