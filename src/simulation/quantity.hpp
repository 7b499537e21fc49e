#pragma once
/// What the emulator knows of itself, as numbers: what a signal may carry, a sensor measure, a condition ask
/// for. One table.

#include <cstddef>
#include <span>
#include <string_view>

#include "simulation/run_state.hpp"

namespace servohil::simulation {

struct Quantity {
  const char* name;    ///< with its unit: "x3_in"
  const char* signal;  ///< of servohil's own DBC: "X3"
  const char* unit;    ///< "in"; empty where there is none
  const char* meaning;
  double (*value)(const RunState&);
  bool repeatable = true;  ///< a replay gives it bit for bit; false: the machine's doing
};

/// All there are. The order stays the same during a run.
std::span<const Quantity> Quantities() noexcept;

/// Its place among them.
inline std::size_t IndexOf(const Quantity& quantity) noexcept {
  return static_cast<std::size_t>(&quantity - Quantities().data());
}

/// By its name or its signal's; null: there is none.
const Quantity* FindQuantity(std::string_view name) noexcept;

}  // namespace servohil::simulation
