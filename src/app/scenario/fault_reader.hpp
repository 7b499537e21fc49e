#pragma once
/// Reads [[fault]] and [[clear]] of a scenario file, in the words of the control socket.

#include "faults/permissions.hpp"
#include "entry.hpp"
#include "servohil/app/recording/recording.hpp"

namespace servohil::app::scenario {

/// `at_s`: after so many ticks of scenario time it comes. All throw UsageError.
std::uint64_t FaultTick(Entry& entry, std::uint64_t duration_ticks);

/// Ticks of scenario time: 1 is the first.
Influence ReadFault(Entry& entry, std::uint64_t duration_ticks, const Permissions& permissions);
Influence ReadClear(Entry& entry, std::uint64_t duration_ticks, const Permissions& permissions);

}  // namespace servohil::app::scenario
