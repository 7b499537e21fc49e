#pragma once
/// What a person reads of a run's state: 80 columns, plain text.

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace servohil::control {

/// @param status  answer to `status`
/// @param faults  answer to `faults`
/// @return lines of at most 80 characters, each ended by LF; texts of the run have no control characters in
/// it.
///   What the view has no place for is listed as it is.
std::string StatusView(const nlohmann::json& status, const nlohmann::json& faults);

}  // namespace servohil::control
