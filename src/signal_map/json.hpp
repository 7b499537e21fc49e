#pragma once
/// The signal_map and frames of it, for pipelines: what `servohil dbc --json` writes.

#include <nlohmann/json_fwd.hpp>

#include "can/frame.hpp"
#include "configuration/configuration.hpp"
#include "signal_map/signal_map.hpp"

namespace servohil::signal_map {

/// {"received":[...],"sent":[...],"load":{...}}: each message with identifier, cycle, protection and signals.
nlohmann::json SignalMapToJson(const SignalMap& signal_map, const configuration::CanSettings& can);

/// Signals of one frame by name, and what the emulator made of it or put into it.
nlohmann::json FrameToJson(const can::Message& message, const SignalMap& signal_map, const can::Frame& frame);

}  // namespace servohil::signal_map
