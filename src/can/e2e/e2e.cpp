#include "can/e2e/e2e.hpp"

namespace servohil::can {
namespace {

constexpr std::uint8_t kPolynomial = 0x1D;  // x⁸ is implied

std::uint8_t Append(std::uint8_t crc, std::uint8_t byte) noexcept {
  unsigned remainder = unsigned{crc} ^ byte;
  for (int bit = 0; bit < 8; ++bit)
    remainder = (remainder & 0x80U) != 0 ? (remainder << 1U) ^ kPolynomial : remainder << 1U;
  return static_cast<std::uint8_t>(remainder);
}

std::uint8_t LowByte(const E2eLayout& layout) noexcept {
  return static_cast<std::uint8_t>(layout.data_id & 0xFFU);
}
std::uint8_t HighByte(const E2eLayout& layout) noexcept {
  return static_cast<std::uint8_t>(layout.data_id >> 8U);
}

std::uint8_t AppendDataId(std::uint8_t crc, const E2eLayout& layout, unsigned counter) noexcept {
  switch (layout.data_id_mode) {
    case DataIdMode::kBoth:
      return Append(Append(crc, LowByte(layout)), HighByte(layout));
    case DataIdMode::kAlt:
      return Append(crc, counter % 2 == 0 ? LowByte(layout) : HighByte(layout));
    case DataIdMode::kLow:
      return Append(crc, LowByte(layout));
    case DataIdMode::kNibble:
      return Append(Append(crc, LowByte(layout)), 0);
  }
  return crc;
}

/// Over Data ID and all bytes but the checksum's own.
std::uint8_t Crc(const E2eLayout& layout, unsigned counter, std::uint8_t start,
                 std::span<const std::uint8_t> data) noexcept {
  std::uint8_t crc = layout.has_data_id ? AppendDataId(start, layout, counter) : start;
  for (std::size_t i = 0; i < static_cast<std::size_t>(layout.size_bytes); ++i) {
    if (i != layout.checksum.byte) crc = Append(crc, data[i]);
  }
  return crc;
}

/// SPN 4207: the sum of the data bytes 1 to 7, the counter and the identifier's four bytes, folded to 3 bits.
/// Wherever counter and checksum lie: their bits do not count in the bytes that they share with others.
std::uint8_t J1939Checksum(const E2eLayout& layout, std::uint32_t frame_id, unsigned counter,
                           std::span<const std::uint8_t> data) noexcept {
  unsigned sum = counter & 0x0FU;
  for (unsigned shift = 0; shift < 32; shift += 8) sum += (frame_id >> shift) & 0xFFU;
  for (std::size_t i = 0; i < static_cast<std::size_t>(layout.size_bytes); ++i) {
    unsigned byte = data[i];
    for (const ByteField* field : {&layout.counter, &layout.checksum}) {
      if (field->byte == i) byte &= ~(field->Mask() << static_cast<unsigned>(field->low_bit));
    }
    sum += byte;
  }
  return static_cast<std::uint8_t>((((sum >> 6U) & 3U) + (sum >> 3U) + sum) & 7U);
}

std::uint8_t Checksum(const E2eLayout& layout, std::uint32_t frame_id, unsigned counter,
                      std::span<const std::uint8_t> data) noexcept {
  switch (layout.profile) {
    case E2eProfile::kCrc8J1850:
      return static_cast<std::uint8_t>(Crc(layout, counter, 0xFF, data) ^ 0xFFU);
    case E2eProfile::kJ1939CounterChecksum:
      return J1939Checksum(layout, frame_id, counter, data);
    default:
      return Crc(layout, counter, 0, data);
  }
}

bool SendsNibble(const E2eLayout& layout) noexcept {
  return layout.has_data_id && layout.data_id_mode == DataIdMode::kNibble;
}

}  // namespace

std::uint8_t Crc8J1850(std::span<const std::uint8_t> data) noexcept {
  std::uint8_t crc = 0xFF;
  for (const std::uint8_t byte : data) crc = Append(crc, byte);
  return static_cast<std::uint8_t>(crc ^ 0xFFU);
}

unsigned CounterOf(const E2eLayout& layout, std::span<const std::uint8_t> data) noexcept {
  return layout.counter.Read(data);
}

void Protect(const E2eLayout& layout, std::uint32_t frame_id, unsigned counter,
             std::span<std::uint8_t> data) noexcept {
  if (layout.profile == E2eProfile::kNone) return;
  layout.counter.Write(counter, data);
  if (SendsNibble(layout)) layout.nibble.Write(HighByte(layout), data);
  if (HasChecksum(layout)) layout.checksum.Write(Checksum(layout, frame_id, counter, data), data);
}

void InvertChecksum(const E2eLayout& layout, std::span<std::uint8_t> data) noexcept {
  if (HasChecksum(layout)) layout.checksum.Write(~layout.checksum.Read(data), data);
}

bool IsIntact(const E2eLayout& layout, std::uint32_t frame_id, std::span<const std::uint8_t> data) noexcept {
  if (layout.profile == E2eProfile::kNone) return true;
  const unsigned counter = CounterOf(layout, data);
  if (counter >= layout.modulus) return false;
  if (SendsNibble(layout) && layout.nibble.Read(data) != (HighByte(layout) & 0x0FU)) return false;
  return !HasChecksum(layout) || layout.checksum.Read(data) == Checksum(layout, frame_id, counter, data);
}

}  // namespace servohil::can
