#include "can/e2e/e2e.hpp"

#include <cmath>
#include <string>

#include "base/error.hpp"
#include "can/dbc/bit_chunks.hpp"

namespace servohil::can {
namespace {

constexpr unsigned kAutosarRound = 15;  // 15 itself is not valid
constexpr unsigned kJ1939Round = 8;     // 8 to 14 are reserved, 15: not available
constexpr int kLargestDataId = 0xFFFF;
constexpr int kLargestNibbleId = 0x0FFF;

constexpr ByteField kFirstByte{0, 0, 8};
constexpr ByteField kLowNibbleOfSecond{1, 0, 4};
constexpr ByteField kLowNibbleOfEighth{7, 0, 4};
constexpr ByteField kHighNibbleOfEighth{7, 4, 4};

/// Makes the layout of one message.
class Maker {
 public:
  Maker(const E2eSettings& settings, const Message& message) : settings_(settings), message_(message) {
    layout_.profile = settings.profile;
    layout_.size_bytes = message.size_bytes;
  }

  E2eLayout Make() {
    if (settings_.profile == E2eProfile::kNone) return layout_;
    TakeDataId();
    TakeCounter();
    if (settings_.profile != E2eProfile::kCounter) TakeChecksum();
    if (layout_.has_data_id && layout_.data_id_mode == DataIdMode::kNibble) TakeNibble();
    return layout_;
  }

 private:
  bool IsAutosar() const {
    return settings_.profile == E2eProfile::kAutosarP1 || settings_.profile == E2eProfile::kAutosarP11;
  }
  bool IsJ1939() const { return settings_.profile == E2eProfile::kJ1939CounterChecksum; }

  void TakeDataId() {
    const int id = settings_.data_id;
    const DataIdMode mode = settings_.data_id_mode;
    if (!IsAutosar() && settings_.profile != E2eProfile::kCrc8J1850) {
      if (id != kNoDataId) Fail("has no Data ID: leave data_id out");
      return;
    }
    if (IsAutosar() && id == kNoDataId) Fail("needs a Data ID: data_id = 0 to 65535");
    if (settings_.profile == E2eProfile::kAutosarP11 && mode != DataIdMode::kBoth &&
        mode != DataIdMode::kNibble) {
      Fail("takes the Data ID as \"both\" or \"nibble\"");
    }
    if (!IsAutosar() && mode != DataIdMode::kBoth) Fail("takes the Data ID as \"both\" only");
    const int largest = mode == DataIdMode::kNibble ? kLargestNibbleId : kLargestDataId;
    if (id > largest)
      Fail("has a Data ID of " + std::to_string(id) + ", expected 0 to " + std::to_string(largest));
    layout_.has_data_id = id != kNoDataId;
    layout_.data_id = layout_.has_data_id ? static_cast<std::uint16_t>(id) : std::uint16_t{0};
    layout_.data_id_mode = mode;
  }

  void TakeCounter() {
    layout_.counter =
        Take(settings_.counter, IsJ1939() ? kLowNibbleOfEighth : kLowNibbleOfSecond, "the counter");
    const bool four = IsAutosar() || IsJ1939();
    const int bits = layout_.counter.length_bits;
    if (four && (bits != 4 || layout_.counter.low_bit % 4 != 0)) {
      Fail("has a counter of 4 bits at bit 0 or 4 of a byte, not of " + std::to_string(bits) + " at bit " +
           std::to_string(layout_.counter.low_bit));
    }
    if (bits < 2) Fail("has a counter of 2 to 8 bits, not of " + std::to_string(bits));
    layout_.modulus = IsAutosar() ? kAutosarRound : IsJ1939() ? kJ1939Round : OwnRound();
  }

  /// What the DBC says of the counter.
  unsigned OwnRound() const {
    const unsigned all = layout_.counter.Mask() + 1;
    if (settings_.counter == nullptr || !(settings_.counter->maximum > 0.0)) return all;
    const double stated = std::floor(settings_.counter->maximum) + 1.0;
    if (stated < 4.0) Fail("needs a counter that goes to 3 or more");
    return stated < static_cast<double>(all) ? static_cast<unsigned>(stated) : all;
  }

  void TakeChecksum() {
    layout_.checksum = Take(settings_.checksum, IsJ1939() ? kHighNibbleOfEighth : kFirstByte, "the checksum");
    const int bits = IsJ1939() ? 4 : 8;
    if (layout_.checksum.length_bits != bits) {
      Fail("has a checksum of " + std::to_string(bits) + " bits, not of " +
           std::to_string(layout_.checksum.length_bits));
    }
  }

  void TakeNibble() {
    layout_.nibble = {layout_.counter.byte, 4 - layout_.counter.low_bit, 4};
    RequireFree(layout_.nibble, "the Data ID's nibble");
  }

  ByteField Take(const Signal* signal, const ByteField& own_position, const std::string& what) const {
    if (signal == nullptr) {
      RequireFree(own_position, what);
      return own_position;
    }
    const int low = signal->little_endian ? signal->start_bit : signal->start_bit - signal->length_bits + 1;
    const bool one_byte = signal->length_bits <= 8 && low >= 0 &&
                          low / 8 == (low + signal->length_bits - 1) / 8 && low / 8 < message_.size_bytes;
    if (!one_byte || signal->type != ValueType::kInteger)
      Fail("has " + what + " within one byte; the signal " + signal->name + " does not lie so");
    return {static_cast<std::size_t>(low / 8), low % 8, signal->length_bits};
  }

  /// At a position that no signal was named for.
  void RequireFree(const ByteField& field, const std::string& what) const {
    const int first = static_cast<int>(field.byte) * 8 + field.low_bit;
    const std::string place = "bits " + std::to_string(first) + " to " +
                              std::to_string(first + field.length_bits - 1) + " for " + what;
    if (static_cast<int>(field.byte) >= message_.size_bytes)
      Fail("needs " + place + ": the message has " + std::to_string(message_.size_bytes) + " bytes");
    for (const Signal& signal : message_.signals) {
      if (Touches(signal, field)) {
        Fail("needs " + place + ", where the signal " + signal.name +
             " lies: name the signal if it is meant, counter = or checksum =");
      }
    }
  }

  static bool Touches(const Signal& signal, const ByteField& field) {
    bool touches = false;
    ForEachChunk(signal, [&](const BitChunk& chunk) {
      touches = touches || (chunk.byte == field.byte && chunk.low_bit < field.low_bit + field.length_bits &&
                            field.low_bit < chunk.low_bit + chunk.count);
    });
    return touches;
  }

  [[noreturn]] void Fail(const std::string& what) const {
    throw base::UsageError(message_.name + ": e2e = \"" +
                           kE2eProfileNames[static_cast<std::size_t>(settings_.profile)] + "\" " + what);
  }

  const E2eSettings& settings_;
  const Message& message_;
  E2eLayout layout_;
};

}  // namespace

E2eLayout MakeE2eLayout(const E2eSettings& settings, const Message& message) {
  return Maker(settings, message).Make();
}

}  // namespace servohil::can
