#pragma once
/// What is told to the outside at one moment: the truth, what the sensors say of it, and what becomes of the
/// frames. Plain structs that cross threads.

#include <array>
#include <cstddef>
#include <cstdint>

#include "fault/acts.hpp"
#include "simulation/quantity.hpp"
#include "simulation/run_state.hpp"

namespace servohil::simulation {

inline constexpr std::size_t kMaxQuantities = 64;

/// What the sensors say. Not a number: not available; infinite: as much as the signal can say.
struct Measured {
  std::uint64_t changed = 0;  ///< bit i: quantity i is not what it is in truth, but values[i]
  std::array<double, kMaxQuantities> values{};  ///< in the order of Quantities()

  /// @param truth  what is measured
  double Of(const Quantity& quantity, const RunState& truth) const noexcept {
    const std::size_t i = IndexOf(quantity);
    return (changed >> i & 1U) != 0 ? values[i] : quantity.value(truth);
  }
};

struct Publication {
  RunState run_state;
  Measured measured;
  fault::Transmission fate;  ///< of its frames
};

}  // namespace servohil::simulation
