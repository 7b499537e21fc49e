#pragma once
/// The control oil pressure over time, as a file gives it: CSV `t_s,p1_psi`, each value from the first tick
/// at or after its time.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "recording/recording.hpp"

namespace servohil::run {

/// As commands. @throws UsageError "FILE:LINE: ..."
std::vector<recording::Stimulus> ReadP1Script(const std::filesystem::path& file);

/// P1 from the tick that begins after so many.
recording::Stimulus CommandAfter(std::uint64_t ticks, double p1_psi);

}  // namespace servohil::run
