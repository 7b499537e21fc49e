#pragma once
/// The attributes of a DBC file (BA_DEF_, BA_DEF_DEF_, BA_) that tell how a message is sent.

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "can/dbc/dbc.hpp"
#include "can/dbc/dbc_lexer.hpp"

namespace servohil::can {

/// Collects the statements, wherever they stand, then applies them. Statements of no known form are passed
/// over: attributes are the part of the format in which tools differ most.
class DbcAttributes {
 public:
  /// Tokens of one statement between its keyword and its ';'.
  using Statement = std::span<const Token>;

  void Define(Statement statement);   ///< BA_DEF_
  void Default(Statement statement);  ///< BA_DEF_DEF_
  void Set(Statement statement);      ///< BA_

  /// Format, bit-rate switch and cycle time of the message with this id of BO_, start values of its signals.
  void Apply(std::uint32_t raw_id, Message& message) const;

 private:
  /// Value of an attribute: of the signal `signal`, or where that is empty of the message.
  std::string ValueOf(const std::string& attribute, std::uint32_t raw_id, const std::string& signal) const;
  /// "J1939PG", "StandardCAN_FD", ...: whether VFrameFormat is an enumeration or a number.
  std::string FrameFormatOf(std::uint32_t raw_id) const;
  double NumberOf(const std::string& attribute, std::uint32_t raw_id, const std::string& signal) const;

  std::map<std::string, std::vector<std::string>> enumerations_;
  std::map<std::string, std::string> defaults_;
  std::map<std::tuple<std::string, std::uint32_t, std::string>, std::string> values_;
};

}  // namespace servohil::can
