#pragma once
/// Who goes first.

#include <cstdint>

#include "servohil/can/frame.hpp"

namespace servohil::can {

/// Among frames that begin at once the smallest wins: the bits of the arbitration field in their order, a
/// dominant one 0. A standard frame wins against an extended one with the same first 11 bits, a data frame
/// against a remote one.
std::uint32_t ArbitrationRank(const Frame& frame) noexcept;

}  // namespace servohil::can
