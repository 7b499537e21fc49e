#include "signal_map/protection.hpp"

#include "base/formatted.hpp"

namespace servohil::signal_map {
namespace {

std::string BitsText(const can::ByteField& field) {
  const int first = static_cast<int>(field.byte) * 8 + field.low_bit;
  return base::Formatted("bits %d to %d", first, first + field.length_bits - 1);
}

bool LiesAt(const can::Signal& signal, const can::ByteField& field) {
  const int low = signal.little_endian ? signal.start_bit : signal.start_bit - signal.length_bits + 1;
  return low == static_cast<int>(field.byte) * 8 + field.low_bit && signal.length_bits == field.length_bits;
}

}  // namespace

std::string ProtectionLine(const std::optional<can::E2eLayout>& protection) {
  if (!protection) return {};
  std::string text =
      std::string("    e2e ") + can::kE2eProfileNames[static_cast<std::size_t>(protection->profile)];
  if (protection->has_data_id) {
    text += base::Formatted(", Data ID 0x%X ", unsigned{protection->data_id}) +
            can::kDataIdModeNames[static_cast<std::size_t>(protection->data_id_mode)];
  }
  text += base::Formatted(": counter 0 to %u in ", protection->modulus - 1) + BitsText(protection->counter);
  return text + (can::HasChecksum(*protection) ? ", checksum in " + BitsText(protection->checksum) : "") +
         "\n";
}

const char* RoleOf(const std::optional<can::E2eLayout>& protection, const can::Signal& signal) {
  if (!protection) return nullptr;
  if (LiesAt(signal, protection->counter)) return "counter";
  return can::HasChecksum(*protection) && LiesAt(signal, protection->checksum) ? "checksum" : nullptr;
}

bool IsIntact(const std::optional<can::E2eLayout>& protection, const can::Frame& frame) {
  return !protection || can::IsIntact(*protection, frame.id, {frame.data.data(), frame.size});
}

}  // namespace servohil::signal_map
