#include "can/dbc/dbc_lexer.hpp"

#include <array>

#include "base/error.hpp"

namespace servohil::can {
namespace {

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}
bool IsNameStart(char c) {
  // Bytes above 127 are letters of names in other alphabets (not valid DBC, but written by some tools).
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_' || static_cast<unsigned char>(c) > 127;
}
bool IsNamePart(char c) {
  return IsNameStart(c) || IsDigit(c);
}
bool IsSpace(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v';
}

/// Length of the UTF-8 sequence that begins at text[at]; 0 when there is none.
std::size_t Utf8Length(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  struct Form {
    unsigned mask, lead;
    std::size_t length;
  };
  if (byte(at) < 0x80) return 1;
  constexpr std::array<Form, 3> kForms{{{0xE0, 0xC0, 2}, {0xF0, 0xE0, 3}, {0xF8, 0xF0, 4}}};
  for (const Form& form : kForms) {
    if ((byte(at) & form.mask) != form.lead) continue;
    if (at + form.length > text.size() || byte(at) == 0xC0 || byte(at) == 0xC1) return 0;
    for (std::size_t i = 1; i < form.length; ++i) {
      if ((byte(at + i) & 0xC0U) != 0x80U) return 0;
    }
    return form.length;
  }
  return 0;
}

bool IsUtf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = Utf8Length(text, at);
    if (length == 0) return false;
    at += length;
  }
  return true;
}

}  // namespace

std::string ToUtf8(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.substr(0, kByteOrderMark.size()) == kByteOrderMark) text.remove_prefix(kByteOrderMark.size());
  if (IsUtf8(text)) return std::string(text);
  std::string utf8;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      utf8 += c;
    } else {
      utf8 += static_cast<char>(0xC0U | (byte >> 6U));
      utf8 += static_cast<char>(0x80U | (byte & 0x3FU));
    }
  }
  return utf8;
}

std::string Describe(const Token& token) {
  constexpr std::size_t kMaxShown = 30;
  std::string shown = token.text.substr(0, kMaxShown);
  shown = shown.substr(0, shown.find_first_of("\r\n"));
  if (shown.size() < token.text.size()) shown += "...";
  switch (token.kind) {
    case TokenKind::kEnd:
      return "the end of the file";
    case TokenKind::kString:
      return "the string \"" + shown + "\"";
    default:
      return "'" + shown + "'";
  }
}

void DbcLexer::Fail(int line, const std::string& what) const {
  throw base::UsageError(file_ + ":" + std::to_string(line) + ": " + what);
}

void DbcLexer::SkipSpace() {
  while (at_ < text_.size() && IsSpace(text_[at_])) {
    if (text_[at_] == '\n') ++line_;
    ++at_;
  }
}

void DbcLexer::ReadString(Token& token) {
  token.kind = TokenKind::kString;
  for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) {
    if (Look() == '\\' && (Look(1) == '"' || Look(1) == '\\')) ++at_;
    if (text_[at_] == '\n') ++line_;
    token.text += text_[at_];
  }
  if (at_ >= text_.size()) Fail(token.line, "this string has no closing '\"'");
  ++at_;
}

void DbcLexer::ReadNumber(Token& token) {
  token.kind = TokenKind::kNumber;
  const std::size_t begin = at_;
  if (Look() == '+' || Look() == '-') ++at_;
  while (IsDigit(Look()) || Look() == '.') ++at_;
  const bool has_sign = Look(1) == '+' || Look(1) == '-';
  if ((Look() == 'e' || Look() == 'E') && IsDigit(Look(has_sign ? 2 : 1))) {
    at_ += has_sign ? 2 : 1;
    while (IsDigit(Look())) ++at_;
  }
  const std::size_t end = at_;
  while (IsNamePart(Look()) || Look() == '.') ++at_;
  token.text = text_.substr(begin, at_ - begin);
  if (at_ != end) Fail(token.line, "'" + token.text + "' is neither a number nor a name");
}

Token DbcLexer::Next() {
  SkipSpace();
  Token token;
  token.line = line_;
  const char c = Look();
  const char sign_next = Look(1);
  if (at_ >= text_.size()) {
    token.kind = TokenKind::kEnd;
  } else if (c == '"') {
    ReadString(token);
  } else if (IsDigit(c) || ((c == '+' || c == '-' || c == '.') && (IsDigit(sign_next) || sign_next == '.'))) {
    ReadNumber(token);
  } else if (IsNameStart(c)) {
    token.kind = TokenKind::kName;
    while (IsNamePart(Look())) token.text += text_[at_++];
  } else {
    token.kind = TokenKind::kMark;
    token.text = text_[at_++];
  }
  token.end_line = line_;
  return token;
}

}  // namespace servohil::can
