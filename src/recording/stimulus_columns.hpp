#pragma once
/// The columns of the group `stimuli`: one line each, for writer and reader.

#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <variant>

#include "recording/recording.hpp"
#include "recording/sample_columns.hpp"

namespace servohil::recording {

/// Where a column's value lives.
using StimulusPlace =
    std::variant<double& (*)(Stimulus&), std::uint64_t& (*)(Stimulus&), std::uint32_t& (*)(Stimulus&),
                 std::uint8_t& (*)(Stimulus&), bool& (*)(Stimulus&),
                 simulation::Request::Kind& (*)(Stimulus&), fault::Trigger::Kind& (*)(Stimulus&),
                 simulation::SafetyState& (*)(Stimulus&), simulation::SafetyCause& (*)(Stimulus&)>;

/// The type that a value has on file.
template <typename T>
using StoredInfluence = std::conditional_t<std::is_same_v<T, std::uint32_t>, std::uint64_t, Stored<T>>;

struct StimulusColumn {
  const char* name;
  const char* unit;
  std::string description;
  StimulusPlace place;
  bool required = true;  ///< false: added later, older recordings do not have it
};

std::span<const StimulusColumn> StimulusColumns();

}  // namespace servohil::recording
