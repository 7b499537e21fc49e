#pragma once
/// The columns of the group `influences`: one line each, for writer and reader.

#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <variant>

#include "recording/recording.hpp"
#include "recording/sample_columns.hpp"

namespace servohil::recording {

/// Where a column's value lives.
using InfluencePlace =
    std::variant<double& (*)(Influence&), std::uint64_t& (*)(Influence&), std::uint32_t& (*)(Influence&),
                 std::uint8_t& (*)(Influence&), bool& (*)(Influence&),
                 simulation::Request::Kind& (*)(Influence&), fault::Trigger::Kind& (*)(Influence&),
                 simulation::SafetyState& (*)(Influence&), simulation::SafetyCause& (*)(Influence&)>;

/// The type that a value has on file.
template <typename T>
using StoredInfluence = std::conditional_t<std::is_same_v<T, std::uint32_t>, std::uint64_t, Stored<T>>;

struct InfluenceColumn {
  const char* name;
  const char* unit;
  std::string description;
  InfluencePlace place;
  bool required = true;  ///< false: added later, older recordings do not have it
};

std::span<const InfluenceColumn> InfluenceColumns();

}  // namespace servohil::recording
