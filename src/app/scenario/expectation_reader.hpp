#pragma once
/// Reads [[expect]] of a scenario file.

#include "entry.hpp"
#include "scenario.hpp"

namespace servohil::app::scenario {

/// @param fault_starts  (name, tick of scenario time) of each fault in the file
Expectation ReadExpectation(Entry& entry, std::uint64_t duration_ticks,
                            const std::vector<std::pair<std::string, std::uint64_t>>& fault_starts);

}  // namespace servohil::app::scenario
