#pragma once
/// A message's end-to-end protection, for people and pipelines.

#include <optional>
#include <string>

#include "can/e2e/e2e.hpp"
#include "can/frame.hpp"

namespace servohil::signal_map {

/// "    e2e autosar_p1, Data ID 0x123 alt: counter 0 to 14 in bits 8 to 11, checksum in bits 0 to 7"; empty:
/// none.
std::string ProtectionLine(const std::optional<can::E2eLayout>& protection);

/// What e2e has in the signal: "counter", "checksum", or null.
const char* RoleOf(const std::optional<can::E2eLayout>& protection, const can::Signal& signal);

/// Whether counter and checksum of a frame of this message are possible; always without protection.
bool IsIntact(const std::optional<can::E2eLayout>& protection, const can::Frame& frame);

}  // namespace servohil::signal_map
