#pragma once
/// How long a frame keeps the bus, in bits, at worst-case stuffing, interframe space included; and who goes
/// first.

#include <cstdint>

#include "can/dbc/dbc.hpp"
#include "can/frame.hpp"

namespace servohil::can {

struct FrameBits {
  int nominal = 0;  ///< at the nominal bit rate
  int data = 0;     ///< CAN FD with bit-rate switch: at the second bit rate
};

/// Classical frame with `size_bytes` of data. Davis, Burns, Bril, Lukkien, "Controller Area Network
/// schedulability analysis", Real-Time Systems 35 (2007), eq. (1): g + 8s + 13 + floor((g + 8s - 1)/4),
/// g = 34 (standard) or 54 (extended).
int WorstCaseFrameBits(int size_bytes, bool extended) noexcept;

/// CAN FD frame, ISO 11898-1:2015. `size_bytes` is padded to 12, 16, 20, 24, 32, 48, 64.
///   arbitration: SOF, identifier, RRS or SRR IDE, FDF, res, BRS: 17 bits (standard) or 36 (extended), a
///   stuff
///                bit after each four of them but the first; at the end 13: CRC and ACK delimiter, ACK, EOF
///                7, interframe space 3
///   data:        ESI, DLC 4, data, stuffed alike; stuff count 4 and CRC 17 (to 16 bytes) or 21 with a fixed
///                stuff bit before the first and after each four: 6 or 7
/// Without bit-rate switch all of it is nominal.
FrameBits WorstCaseFdFrameBits(int size_bytes, bool extended, bool bit_rate_switch) noexcept;

/// Of a message of a DBC file.
FrameBits WorstCaseBits(const Message& message) noexcept;
/// Of any frame; a remote frame has no data.
FrameBits WorstCaseBits(const Frame& frame) noexcept;

/// Among frames that begin at once the smallest wins: the bits of the arbitration field in their order, a
/// dominant one 0. A standard frame wins against an extended one with the same first 11 bits, a data frame
/// against a remote one.
std::uint32_t ArbitrationRank(const Frame& frame) noexcept;

}  // namespace servohil::can
