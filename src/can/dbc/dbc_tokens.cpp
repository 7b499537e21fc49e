#include "can/dbc/dbc_tokens.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

#include "base/error.hpp"

namespace servohil::can {

void DbcTokens::Fail(int line, const std::string& what) const {
  throw base::UsageError(file_ + ":" + std::to_string(line) + ": " + what);
}

void DbcTokens::FailExpected(const std::string& expected) const {
  Fail(ahead_.line, "expected " + expected + ", found " + Describe(ahead_));
}

Token DbcTokens::Advance() {
  Token old = std::move(ahead_);
  ahead_ = lexer_.Next();
  return old;
}

Token DbcTokens::Take(TokenKind kind, const std::string& what) {
  if (ahead_.kind != kind) FailExpected(what);
  return Advance();
}

void DbcTokens::TakeMark(std::string_view mark, const std::string& where) {
  if (!AtMark(mark)) FailExpected("'" + std::string(mark) + "' " + where);
  Advance();
}

double DbcTokens::TakeNumber(const std::string& what) {
  if (ahead_.kind != TokenKind::kNumber) FailExpected(what);
  const char* begin = ahead_.text.data();
  const char* end = begin + ahead_.text.size();
  if (*begin == '+') ++begin;
  double value = 0.0;
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error != std::errc{} || stop != end) FailExpected(what);
  Advance();
  return value;
}

std::int64_t DbcTokens::TakeInteger(const std::string& what, std::int64_t lowest, std::int64_t highest) {
  const Token found = ahead_;
  // Doubles hold every integer that such a field may have: identifiers have 32 bits.
  const double value = TakeNumber(what);
  if (value != std::floor(value) || value < static_cast<double>(lowest) ||
      value > static_cast<double>(highest)) {
    Fail(found.line, "expected " + what + " (" + std::to_string(lowest) + " to " + std::to_string(highest) +
                         "), found " + Describe(found));
  }
  return static_cast<std::int64_t>(value);
}

std::int64_t DbcTokens::TakeRawValue() {
  const std::string text = ahead_.text;
  const double rounded = TakeNumber("a value");
  const char* end = text.data() + text.size();
  std::int64_t value = 0;
  const auto [value_end, value_error] = std::from_chars(text.data(), end, value);
  if (value_end == end && value_error == std::errc{}) return value;
  std::uint64_t large = 0;
  const auto [stop, error] = std::from_chars(text.data(), end, large);
  if (stop == end && error == std::errc{}) return static_cast<std::int64_t>(large);
  constexpr double kExact = 9007199254740992.0;  // 2^53
  return static_cast<std::int64_t>(std::clamp(rounded, -kExact, kExact));
}

}  // namespace servohil::can
