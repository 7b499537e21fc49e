#pragma once
/// Reader of the part of the DBC format (Vector CANdb) that a node needs: BO_, SG_, VAL_, CM_, SIG_VALTYPE_,
/// SG_MUL_VAL_, and the attributes (BA_DEF_, BA_DEF_DEF_, BA_) VFrameFormat, CANFD_BRS, GenMsgCycleTime and
/// GenSigStartValue. Every other statement is skipped, over several lines where it has them.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace servohil::can {

/// What the raw bits are.
enum class ValueType : std::uint8_t { kInteger, kFloat32, kFloat64 };

/// When a signal is in a frame.
enum class Multiplexing : std::uint8_t {
  kAlways,
  kSelector,  ///< M: always, and its raw value tells which of the others are
  kSelected,  ///< m0, m1, ...: where the selector has the value `selected_by`
  kExtended,  ///< m0M, or selected by several values (SG_MUL_VAL_): can be read, not used
};

struct Signal {
  std::string name;
  int start_bit = 0;    ///< as in the file: bit of the LSB (Intel) or of the MSB (Motorola, DBC numbering)
  int length_bits = 0;  ///< 1 to 64
  bool little_endian = true;  ///< @1 Intel, @0 Motorola
  bool is_signed = false;
  double factor = 1.0;  ///< physical = raw * factor + offset
  double offset = 0.0;
  double minimum = 0.0;  ///< physical range; minimum == maximum == 0: not stated
  double maximum = 0.0;
  std::string unit;     ///< UTF-8, whatever the file's encoding
  std::string comment;  ///< UTF-8
  std::map<std::int64_t, std::string> value_names;
  Multiplexing multiplexing = Multiplexing::kAlways;
  std::int64_t selected_by = 0;
  ValueType type = ValueType::kInteger;  ///< SIG_VALTYPE_ 1 or 2: IEEE 754
  double start_raw = 0.0;                ///< GenSigStartValue: raw value while nobody sets one
  int line = 0;                          ///< in the file, from 1
};

struct Message {
  std::string name;
  std::uint32_t id = 0;
  bool extended = false;
  bool fd = false;               ///< CAN FD: VFrameFormat says so, or more than 8 bytes
  bool bit_rate_switch = false;  ///< of CAN FD: CANFD_BRS is "1"
  bool j1939 = false;            ///< VFrameFormat is J1939PG
  int size_bytes = 0;
  int cycle_ms = 0;  ///< GenMsgCycleTime; 0: not stated
  std::string sender;
  std::string comment;
  std::vector<Signal> signals;
  int line = 0;

  const Signal* FindSignal(std::string_view signal_name) const;
  /// The multiplexer M; null: there is none.
  const Signal* Selector() const;
};

struct Database {
  std::string file;  ///< for error messages
  std::vector<Message> messages;

  const Message* FindMessage(std::string_view message_name) const;
  /// @throws UsageError naming the file, and the nearest name when there is none of this one, or the line
  /// when
  ///         the message uses what is not supported: extended multiplexing, more than 64 bytes
  const Message& RequireMessage(std::string_view message_name) const;
  /// @throws UsageError naming file, line of the message, and the nearest name
  const Signal& RequireSignal(const Message& message, std::string_view signal_name) const;
};

/// Several files as one.
struct Databases {
  std::vector<Database> files;

  struct Found {
    const Database* database;
    const Message* message;
  };
  /// @throws UsageError as Database::RequireMessage; when two files have the name, or another file a message
  ///         with the same id: which one counts is not to be guessed
  Found RequireMessage(std::string_view message_name) const;
};

/// Text may be UTF-8 or Latin-1, lines may end in LF, CR LF or CR.
/// @throws UsageError "FILE:LINE: ..." with what was found and what was expected: syntax, a signal outside
/// its
///         message or longer than 64 bits, signals that overlap, a name or id that is there twice
Database ParseDbc(std::string_view text, const std::string& file);
/// @throws UsageError as ParseDbc, and when the file cannot be read
Database ReadDbc(const std::filesystem::path& file);
/// The same for several, in this order.
Databases ReadDbcs(const std::vector<std::string>& files);

}  // namespace servohil::can
