#pragma once
/// Reads [[fault]] and [[clear]] of a scenario file, in the words of the control socket.

#include "fault_words/permissions.hpp"
#include "recording/recording.hpp"
#include "scenario/entry.hpp"

namespace servohil::scenario {

/// `at_s`: after so many ticks of scenario time it comes. All throw UsageError.
std::uint64_t FaultTick(Entry& entry, std::uint64_t duration_ticks);

/// Ticks of scenario time: 1 is the first.
recording::Stimulus ReadFault(Entry& entry, std::uint64_t duration_ticks,
                              const fault_words::Permissions& permissions);
recording::Stimulus ReadClear(Entry& entry, std::uint64_t duration_ticks,
                              const fault_words::Permissions& permissions);

}  // namespace servohil::scenario
