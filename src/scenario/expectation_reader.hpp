#pragma once
/// Reads [[expect]] of a scenario file.

#include "scenario/entry.hpp"
#include "scenario/scenario.hpp"

namespace servohil::scenario {

/// @param fault_starts  (name, tick of scenario time) of each fault in the file
Expectation ReadExpectation(Entry& entry, std::uint64_t duration_ticks,
                            const std::vector<std::pair<std::string, std::uint64_t>>& fault_starts);

}  // namespace servohil::scenario
