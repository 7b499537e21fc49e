#pragma once
/// From the names in the configuration to messages and signals of the DBC files; whatever does not fit is
/// found here.

#include <vector>

#include "servohil/app/contract.hpp"

namespace servohil::app {

/// The governor's messages, the one with P1 first. The pointers are into `databases`.
/// @throws UsageError: unknown names, units, a range in which the valve cannot be opened or closed
std::vector<ReceivedMessage> BindCommand(const can::Databases& databases, const Configuration& configuration);

/// The emulator's messages: those of can.publish, else servohil's own with the cycle times of [publish].
/// @throws UsageError: unknown names, units, cycle times, a range that the stroke leaves
std::vector<PublishedMessage> BindPublished(const can::Databases& databases,
                                            const Configuration& configuration);

/// @throws UsageError: two messages with one identifier
void CheckIdentifiers(std::span<const ReceivedMessage> incoming, std::span<const PublishedMessage> outgoing);

}  // namespace servohil::app
