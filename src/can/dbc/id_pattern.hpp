#pragma once
/// Which frames a message of a DBC file stands for: those of its identifier, or of its J1939 parameter group
/// from any source.

#include <cstdint>

#include "can/bus.hpp"
#include "can/frame.hpp"

namespace servohil::can {

/// Parameter group number of a 29-bit identifier, SAE J1939-21: extended data page, data page, PDU format
/// and, from format 240 (PDU2) on, its group extension. Below (PDU1) that byte is the destination, no part of
/// it.
std::uint32_t PgnOf(std::uint32_t id) noexcept;

struct IdPattern {
  std::uint32_t id = 0;
  bool extended = false;
  /// Compares the parameter group only, not priority and source address. A destination (PDU1) must be that of
  /// `id`, or all (255); 254 and 255 in `id` leave it open, too. For extended identifiers only.
  bool pgn = false;

  /// Data and remote frames alike. Real-time safe.
  bool Matches(std::uint32_t frame_id, bool frame_extended) const noexcept;
  /// For the kernel's filter: what matches, and no more than a mask can keep apart.
  WantedId Wanted() const noexcept;
};

/// Whether a frame could match both.
bool Overlap(const IdPattern& a, const IdPattern& b) noexcept;

}  // namespace servohil::can
