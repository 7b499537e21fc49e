#pragma once
/// Tokens of a DBC file.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace servohil::can {

enum class TokenKind : std::uint8_t { kName, kNumber, kString, kMark, kEnd };

struct Token {
  TokenKind kind = TokenKind::kEnd;
  std::string text;  ///< of a string: without quotes, escapes resolved
  int line = 0;      ///< where it begins, from 1
  int end_line = 0;  ///< where it ends: strings may go over several lines
};

/// How an error message calls the token: "end of file", a string "..." or the text itself in quotes.
std::string Describe(const Token& token);

/// Cuts the text into names, numbers ("-1.5E-3"), strings and single marks (: ; | @ ( ) [ ] , + -).
/// In "@1+" the sign is a mark: it belongs to a number only where a digit follows.
class DbcLexer {
 public:
  DbcLexer(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {}

  /// @throws UsageError at a string without end, or a number that runs into letters
  Token Next();

 private:
  char Look(std::size_t ahead = 0) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }
  void SkipSpace();
  void ReadString(Token& token);
  void ReadNumber(Token& token);
  [[noreturn]] void Fail(int line, const std::string& what) const;

  std::string_view text_;
  std::string file_;
  std::size_t at_ = 0;
  int line_ = 1;
};

/// The text as UTF-8: unchanged when it is that already (without a byte order mark), else read as Latin-1.
std::string ToUtf8(std::string_view text);

}  // namespace servohil::can
