#pragma once
/// The signal_map and frames of it, for people.

#include <string>

#include "can/frame.hpp"
#include "configuration/configuration.hpp"
#include "signal_map/signal_map.hpp"

namespace servohil::signal_map {

/// What is received and sent: identifier, cycle, share of the bus, and each signal with what it means.
std::string DescribeSignalMap(const SignalMap& signal_map, const configuration::CanSettings& can);

/// "0x200", "0x0CFF2121".
std::string IdText(std::uint32_t id, bool extended);

/// Signals of one frame with names, units and names of values; those of other multiplexer values left out.
/// @pre frame.size is at least message.size_bytes
std::string DescribeFrame(const can::Message& message, const can::Frame& frame);

/// What the emulator takes from it, or gave into it: "P1 30.27 psi, enabled"; empty: nothing.
std::string DescribeMeaning(const SignalMap& signal_map, const can::Frame& frame);

/// Why a signal of a published message cannot carry its value: "VDU_Feedback.Lift: x3_in leaves -5 to 105 %".
std::string DescribeSaturation(const PublishedMessage& outgoing, FieldSet fields);

}  // namespace servohil::signal_map
