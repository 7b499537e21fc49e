#pragma once
/// The control oil pressure over time, as a file gives it: CSV `t_s,p1_psi`, each value from the first tick
/// at or after its time.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "servohil/app/recording/recording.hpp"

namespace servohil::app {

/// As commands. @throws UsageError "FILE:LINE: ..."
std::vector<Influence> ReadP1Script(const std::filesystem::path& file);

/// P1 from the tick that begins after so many.
Influence CommandAfter(std::uint64_t ticks, double p1_psi);

}  // namespace servohil::app
