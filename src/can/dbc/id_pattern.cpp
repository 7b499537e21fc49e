#include "can/dbc/id_pattern.hpp"

namespace servohil::can {
namespace {

constexpr std::uint32_t kPduFormat = 0x00FF'0000;
constexpr std::uint32_t kFirstPdu2 = 0x00F0'0000;  // format 240
constexpr std::uint32_t kAddress = 0x0000'FF00;    // PDU1: destination; PDU2: group extension
constexpr std::uint32_t kPdu2Group = 0x03FF'FF00;  // both data pages, format, extension
constexpr std::uint32_t kPdu1Group = 0x03FF'0000;
constexpr std::uint32_t kToAll = 0x0000'FF00;
constexpr std::uint32_t kToNobody = 0x0000'FE00;  // the null address: a file that leaves it open

bool IsPdu1(std::uint32_t id) noexcept {
  return (id & kPduFormat) < kFirstPdu2;
}

bool LeavesDestinationOpen(std::uint32_t id) noexcept {
  return (id & kAddress) >= kToNobody;
}

}  // namespace

std::uint32_t PgnOf(std::uint32_t id) noexcept {
  return (id & (IsPdu1(id) ? kPdu1Group : kPdu2Group)) >> 8U;
}

bool IdPattern::Matches(std::uint32_t frame_id, bool frame_extended) const noexcept {
  if (frame_extended != extended) return false;
  if (!pgn) return frame_id == id;
  if (PgnOf(frame_id) != PgnOf(id)) return false;
  return !IsPdu1(id) || LeavesDestinationOpen(id) || (frame_id & kAddress) == kToAll ||
         (frame_id & kAddress) == (id & kAddress);
}

WantedId IdPattern::Wanted() const noexcept {
  if (!pgn) return {id, extended};
  const std::uint32_t mask = IsPdu1(id) ? kPdu1Group : kPdu2Group;
  return {id & mask, extended, mask};
}

bool Overlap(const IdPattern& a, const IdPattern& b) noexcept {
  if (a.extended != b.extended) return false;
  if (!a.pgn) return b.Matches(a.id, a.extended);
  if (!b.pgn) return a.Matches(b.id, b.extended);
  if (PgnOf(a.id) != PgnOf(b.id)) return false;
  return true;  // of different destinations too: a frame to all is for both
}

}  // namespace servohil::can
