#pragma once
/// What a parser of DBC statements reads with: one token ahead, and errors that say what was expected.

#include <cstdint>
#include <string>
#include <string_view>

#include "can/dbc/dbc_lexer.hpp"

namespace servohil::can {

/// Every member that takes something throws UsageError "FILE:LINE: expected ..., found ..." when it is not
/// there.
class DbcTokens {
 public:
  DbcTokens(std::string_view text, const std::string& file) : file_(file), lexer_(text, file) { Advance(); }

  const Token& Ahead() const { return ahead_; }
  bool AtEnd() const { return ahead_.kind == TokenKind::kEnd; }
  bool AtName() const { return ahead_.kind == TokenKind::kName; }
  bool AtName(std::string_view name) const { return AtName() && ahead_.text == name; }
  bool AtMark(std::string_view mark) const { return ahead_.kind == TokenKind::kMark && ahead_.text == mark; }

  Token Advance();
  Token Take(TokenKind kind, const std::string& what);
  /// `where` completes the message: "after the message's name".
  void TakeMark(std::string_view mark, const std::string& where);
  double TakeNumber(const std::string& what);
  std::int64_t TakeInteger(const std::string& what, std::int64_t lowest, std::int64_t highest);
  /// Any 64-bit value, signed or unsigned; some tools write "1.0".
  std::int64_t TakeRawValue();

  [[noreturn]] void Fail(int line, const std::string& what) const;
  [[noreturn]] void FailExpected(const std::string& expected) const;

 private:
  std::string file_;
  DbcLexer lexer_;
  Token ahead_;
};

}  // namespace servohil::can
