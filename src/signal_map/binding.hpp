#pragma once
/// From the names in the configuration to messages and signals of the DBC files; whatever does not fit is
/// found here.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "signal_map/signal_map.hpp"

namespace servohil::signal_map {

/// The governor's messages, the one with P1 first. The pointers are into `databases`.
/// @throws UsageError: unknown names, units, a range in which the valve cannot be opened or closed
std::vector<ReceivedMessage> BindCommand(const can::Databases& databases,
                                         const configuration::Configuration& configuration);

/// The emulator's messages: those of can.publish, else servohil's own with the cycle times of [publish].
/// @throws UsageError: unknown names, units, cycle times, a range that the stroke leaves
std::vector<PublishedMessage> BindPublished(const can::Databases& databases,
                                            const configuration::Configuration& configuration);

/// "bench.toml:14: " of "counter", for errors.
using PlaceOfKey = std::function<std::string(const std::string& key)>;

/// How a message is protected; nothing: it is not.
/// @throws UsageError: unknown signals, fields that do not fit the profile
std::optional<can::E2eLayout> BindProtection(const can::Database& database, const can::Message& message,
                                             const configuration::ProtectionSettings& settings,
                                             const PlaceOfKey& place_of);

/// @throws UsageError: two messages with one identifier
void CheckIdentifiers(std::span<const ReceivedMessage> incoming, std::span<const PublishedMessage> outgoing);

}  // namespace servohil::signal_map
