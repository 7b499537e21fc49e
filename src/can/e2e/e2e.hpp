#pragma once
/// End-to-end protection of frames: a counter and a checksum that tell the receiver what got lost, came
/// twice, came late or was changed on the way.
///
///   counter                 rolling counter only: a changed frame is not noticed
///   crc8_j1850              rolling counter, CRC-8 of SAE J1850 (x⁸+x⁴+x³+x²+1, start and final value 0xFF)
///   autosar_p1, _p11        AUTOSAR E2E profiles 1 and 11: the same polynomial with start and final value 0,
///                           counter 0 to 14, a Data ID that tells messages apart
///                           (AUTOSAR FO PRS E2EProtocol, sections "Specification of E2E Profile 1" and "11")
///   j1939_counter_checksum  as in TSC1: counter 0 to 7, checksum 0 to 7 in 4 bits each
///                           (SAE J1939-71, SPN 4206 and 4207)
///
/// The CRC has a Hamming distance of 4 up to 119 bits (Koopman, 0x8E in his notation): every one, two or
/// three wrong bits of a frame of 8 bytes are found (Data ID mode "alt": where the ID is chosen so,
/// e2e_test.cpp). The J1939 checksum finds every single wrong bit and 89 % of two.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "can/dbc/dbc.hpp"

namespace servohil::can {

enum class E2eProfile : std::uint8_t {
  kNone,
  kCounter,
  kCrc8J1850,
  kAutosarP1,
  kAutosarP11,
  kJ1939CounterChecksum
};
inline constexpr const char* kE2eProfileNames[] = {"none",       "counter",     "crc8_j1850",
                                                   "autosar_p1", "autosar_p11", "j1939_counter_checksum"};

/// What of the 16-bit Data ID goes into the CRC of the AUTOSAR profiles (11 has kBoth and kNibble).
enum class DataIdMode : std::uint8_t {
  kBoth,   ///< low byte, high byte
  kAlt,    ///< low byte where the counter is even, high byte where it is odd
  kLow,    ///< low byte
  kNibble  ///< low byte and 0; bits 8 to 11 of the ID are sent beside the counter
};
inline constexpr const char* kDataIdModeNames[] = {"both", "alt", "low", "nibble"};

inline constexpr int kNoDataId = -1;

/// What the user sets for a message.
struct E2eSettings {
  E2eProfile profile = E2eProfile::kNone;
  int data_id = kNoDataId;  ///< 0 to 65535. AUTOSAR: needed. crc8_j1850: low byte, high byte before the data,
                            ///< if there is one
  DataIdMode data_id_mode = DataIdMode::kBoth;
  const Signal* counter = nullptr;   ///< null: the profile's own position
  const Signal* checksum = nullptr;  ///< null: the profile's own position
};

/// Bits of one data byte.
struct ByteField {
  std::size_t byte = 0;
  int low_bit = 0;
  int length_bits = 0;

  unsigned Mask() const noexcept { return (1U << static_cast<unsigned>(length_bits)) - 1U; }
  unsigned Read(std::span<const std::uint8_t> data) const noexcept {
    return (unsigned{data[byte]} >> static_cast<unsigned>(low_bit)) & Mask();
  }
  void Write(unsigned value, std::span<std::uint8_t> data) const noexcept {
    const auto shift = static_cast<unsigned>(low_bit);
    data[byte] = static_cast<std::uint8_t>((data[byte] & ~(Mask() << shift)) | (value & Mask()) << shift);
  }
};

/// How a message is protected: checked, ready to be used. Trivially copyable.
struct E2eLayout {
  E2eProfile profile = E2eProfile::kNone;
  std::uint16_t data_id = 0;
  bool has_data_id = false;
  DataIdMode data_id_mode = DataIdMode::kBoth;
  int size_bytes = 0;  ///< protected: the whole message
  ByteField counter;
  ByteField checksum;     ///< unused by kCounter
  ByteField nibble;       ///< of the Data ID's bits 8 to 11; unused but by kNibble
  unsigned modulus = 16;  ///< the counter goes from 0 to modulus - 1
};

/// Where counter and checksum of `message` lie. Own positions: counter bits 8 to 11, checksum bits 0 to 7; of
/// J1939 bits 56 to 59 and 60 to 63. The Data ID's nibble is the other half of the counter's byte. A counter
/// of another width, or with a maximum in the DBC, goes round accordingly where the profile does not say.
/// @throws UsageError "MESSAGE: ...": a field does not fit the profile, is spread over bytes or overlaps
///         another signal, the Data ID is missing or has no meaning
E2eLayout MakeE2eLayout(const E2eSettings& settings, const Message& message);

/// CRC-8 of SAE J1850: of "123456789" 0x4B. Real-time safe.
std::uint8_t Crc8J1850(std::span<const std::uint8_t> data) noexcept;

/// Writes counter, Data ID nibble and checksum into `data`, the values of the message being there already.
/// Real-time safe. @param frame_id identifier on the bus (J1939) @pre data.size() >= layout.size_bytes
void Protect(const E2eLayout& layout, std::uint32_t frame_id, unsigned counter,
             std::span<std::uint8_t> data) noexcept;

/// Whether the profile has a checksum.
inline bool HasChecksum(const E2eLayout& layout) noexcept {
  return layout.profile != E2eProfile::kNone && layout.profile != E2eProfile::kCounter;
}
/// Makes a right checksum wrong, whatever the profile: all its bits. Real-time safe. @pre as above
void InvertChecksum(const E2eLayout& layout, std::span<std::uint8_t> data) noexcept;

/// Whether checksum, Data ID nibble and counter range are right. Real-time safe. @pre as above
bool IsIntact(const E2eLayout& layout, std::uint32_t frame_id, std::span<const std::uint8_t> data) noexcept;

/// The counter that the data carry. Real-time safe. @pre as above
unsigned CounterOf(const E2eLayout& layout, std::span<const std::uint8_t> data) noexcept;

/// What a received frame is, by its counter and checksum.
enum class E2eVerdict : std::uint8_t {
  kOk,         ///< the next one, or the first
  kSomeLost,   ///< a later one: some between are lost, no more than are tolerated. Valid
  kTooMany,    ///< a later one, more are lost than are tolerated. Not valid; the next one is compared with it
  kRepeated,   ///< the same counter again, for the first or second time
  kStuck,      ///< the same counter for the third time or more: it stands still
  kReordered,  ///< an older one that comes late
  kCorrupted,  ///< checksum, Data ID or counter are not possible
};

/// Totals since the start.
struct E2eCounters {
  std::uint64_t ok = 0;
  std::uint64_t some_lost = 0;
  std::uint64_t too_many = 0;
  std::uint64_t repeated = 0;
  std::uint64_t stuck = 0;
  std::uint64_t reordered = 0;
  std::uint64_t corrupted = 0;
  std::uint64_t lost_frames = 0;  ///< missing between the others, as the counter tells

  friend bool operator==(const E2eCounters&, const E2eCounters&) = default;
};

/// Follows the counter of one message. Real-time safe.
///
/// The counter's step against the newest frame decides, modulo its round: 0 repeated; 1 the next;
/// up to `max_jump` some lost; the last steps of the round, at most kLateWindow of them and less than half,
/// are older frames; the rest is a loss beyond the tolerance. A sender that starts anew is followed at once
/// or, where that looks like older frames, after at most kLateWindow of them and a repeated one.
class E2eChecker {
 public:
  static constexpr unsigned kLateWindow = 7;
  static constexpr unsigned kRepeatedBeforeStuck = 2;

  /// @param max_jump  largest step of the counter that is valid, 1 or more: 1 tolerates no loss
  E2eChecker(const E2eLayout& layout, unsigned max_jump) noexcept : layout_(layout), max_jump_(max_jump) {}

  /// The next frame from the bus; @pre data.size() >= layout.size_bytes
  E2eVerdict Check(std::uint32_t frame_id, std::span<const std::uint8_t> data) noexcept;
  /// A frame that is too short.
  E2eVerdict Reject() noexcept;

  const E2eCounters& Counters() const noexcept { return counters_; }
  static bool IsValid(E2eVerdict verdict) noexcept {
    return verdict == E2eVerdict::kOk || verdict == E2eVerdict::kSomeLost;
  }

 private:
  E2eVerdict Follow(unsigned counter) noexcept;
  E2eVerdict Repeated() noexcept;

  E2eLayout layout_;
  unsigned max_jump_;
  std::optional<unsigned> newest_;
  unsigned repetitions_ = 0;
  E2eCounters counters_;
};

}  // namespace servohil::can
