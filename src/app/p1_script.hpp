#pragma once
/// The control oil pressure over time, as a file gives it: CSV `t_s,p1_psi`, each value from the first tick
/// at or after its time.

#include <cstdint>
#include <filesystem>
#include <vector>

namespace servohil::app {

struct P1Change {
  std::uint64_t tick;  ///< holds for the tick that begins after so many
  double p1_psi;
};

/// @throws UsageError "FILE:LINE: ..."
std::vector<P1Change> ReadP1Script(const std::filesystem::path& file);

}  // namespace servohil::app
