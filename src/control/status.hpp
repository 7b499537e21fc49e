#pragma once
/// The state of a run as the control socket tells it.

#include <nlohmann/json_fwd.hpp>

#include "emulator/emulator.hpp"
#include "simulation/run_state.hpp"

namespace servohil::control {

/// The answer to `status`, without "id". A new field is one line here and one in PROTOCOL.md: `servohil
/// status` shows whatever there is.
nlohmann::json StatusToJson(const simulation::RunState& now);

/// Messages with frames in which a measured value was more than its signal holds: how many.
nlohmann::json SaturatedToJson(const emulator::Emulator& emulator);

}  // namespace servohil::control
