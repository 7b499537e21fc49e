#pragma once
/// The columns of the group `samples`: one line each, for writer, reader and whoever compares runs.

#include <cstdint>
#include <span>
#include <type_traits>
#include <variant>

#include "simulation/run_state.hpp"

namespace servohil::recording {

/// Where a column's value lives.
using SamplePlace =
    std::variant<double& (*)(simulation::RunState&), std::uint64_t& (*)(simulation::RunState&),
                 std::int64_t& (*)(simulation::RunState&), int& (*)(simulation::RunState&),
                 bool& (*)(simulation::RunState&), simulation::Mode& (*)(simulation::RunState&),
                 model::Motion& (*)(simulation::RunState&), model::Plunger& (*)(simulation::RunState&),
                 simulation::SafetyCause& (*)(simulation::RunState&)>;

/// The type that a value has on file: numbers as they are, flags and enumerations as a byte.
template <typename T>
using Stored = std::conditional_t<std::is_same_v<T, bool> || std::is_enum_v<T>, std::uint8_t, T>;

struct SampleColumn {
  const char* name;  ///< "x3_in"
  const char* unit;  ///< "in"; empty where there is none
  const char* description;
  SamplePlace place;
  bool compressible = true;  ///< false: as good as random
  bool repeatable = true;    ///< a replay gives it bit for bit; false: the machine's doing
  bool required = true;      ///< false: added later, older recordings do not have it
};

std::span<const SampleColumn> SampleColumns();

}  // namespace servohil::recording
