#pragma once
/// Reader of the part of the DBC format (Vector CANdb) that a node needs: BO_, SG_, VAL_, CM_, SIG_VALTYPE_.
/// Every other statement is skipped, over several lines where it has them.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace servohil::can {

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
  bool multiplexed = false;  ///< m0, m1, ... or the multiplexer M itself
  bool is_float = false;     ///< SIG_VALTYPE_ 1 or 2: the raw bits are an IEEE 754 number
  int line = 0;              ///< in the file, from 1
};

struct Message {
  std::string name;
  std::uint32_t id = 0;
  bool extended = false;
  int size_bytes = 0;
  std::string sender;
  std::string comment;
  std::vector<Signal> signals;
  int line = 0;

  const Signal* FindSignal(std::string_view signal_name) const;
};

struct Database {
  std::string file;  ///< for error messages
  std::vector<Message> messages;

  const Message* FindMessage(std::string_view message_name) const;
  /// @throws UsageError naming the file, and the nearest name when there is none of this one, or the line
  /// when
  ///         the message uses what is not supported: multiplexing, floating point, more than 64 bytes
  const Message& RequireMessage(std::string_view message_name) const;
  /// @throws UsageError naming file, line of the message, and the nearest name
  const Signal& RequireSignal(const Message& message, std::string_view signal_name) const;
};

/// Text may be UTF-8 or Latin-1, lines may end in LF or CR LF.
/// @throws UsageError "FILE:LINE: ..." with what was found and what was expected: syntax, a signal outside
/// its
///         message or longer than 64 bits, signals that overlap, a name or id that is there twice
Database ParseDbc(std::string_view text, const std::string& file);
/// @throws UsageError as ParseDbc, and when the file cannot be read
Database ReadDbc(const std::filesystem::path& file);

}  // namespace servohil::can
