#pragma once
/// The state of a run as the control socket tells it.

#include <nlohmann/json_fwd.hpp>

#include "servohil/app/emulator.hpp"
#include "servohil/app/telemetry.hpp"

namespace servohil::app::control {

/// The answer to `status`, without "id". A new field is one line here and one in PROTOCOL.md: `servohil
/// status` shows whatever there is.
nlohmann::json StatusToJson(const Telemetry& now);

/// Messages with frames in which a measured value was more than its signal holds: how many.
nlohmann::json SaturatedToJson(const Emulator& emulator);

}  // namespace servohil::app::control
