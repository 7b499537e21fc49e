#pragma once
/// How long frames are on the bus, and who goes first.

#include <cstdint>

#include "servohil/can/frame.hpp"

namespace servohil::can {

/// Longest time on the bus, in bits, of a classical frame with `size_bytes` of data: worst-case stuffing and
/// interframe space included. Davis, Burns, Bril, Lukkien, "Controller Area Network (CAN) schedulability
/// analysis: refuted, revisited and revised", Real-Time Systems 35 (2007), eq. (1):
/// g + 8s + 13 + floor((g + 8s - 1)/4), g = 34 (standard) or 54 (extended).
int WorstCaseFrameBits(int size_bytes, bool extended) noexcept;

/// The same of any frame. A remote frame has no data. FD: fixed stuff bits and stuff count as in ISO
/// 11898-1:2015, and all of it at the nominal bit rate, which is an upper bound.
int WorstCaseFrameBits(const Frame& frame) noexcept;

/// Among frames that begin at once the smallest wins: the bits of the arbitration field in their order, a
/// dominant one 0. A standard frame wins against an extended one with the same first 11 bits, a data frame
/// against a remote one.
std::uint32_t ArbitrationRank(const Frame& frame) noexcept;

}  // namespace servohil::can
