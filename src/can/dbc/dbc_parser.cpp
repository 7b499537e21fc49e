#include <algorithm>
#include <charconv>
#include <map>
#include <system_error>

#include "can/dbc/dbc.hpp"
#include "can/dbc/dbc_attributes.hpp"
#include "can/dbc/dbc_check.hpp"
#include "can/dbc/dbc_tokens.hpp"

namespace servohil::can {
namespace {

constexpr std::uint32_t kExtendedFlag = 0x8000'0000;  // bit 31 of a BO_ id: 29-bit identifier
// The message that CANdb invents to hold signals of no message (VECTOR__INDEPENDENT_SIG_MSG).
constexpr std::uint32_t kIndependentSignals = 0xC000'0000;
// J1939 transport protocol. Files that describe it can be read; RequireMessage refuses what no frame holds.
constexpr int kLargestSize = 1785;
constexpr int kLongestSignal = 64;

/// "m0", "m12M", "M": multiplexing indicator between a signal's name and its colon. False: it is none.
bool ReadMultiplexing(const std::string& text, Signal& signal) {
  if (text == "M") {
    signal.multiplexing = Multiplexing::kSelector;
    return true;
  }
  if (text.size() < 2 || text.front() != 'm') return false;
  const char* const end = text.data() + text.size() - (text.back() == 'M' ? 1 : 0);
  const auto [stop, error] = std::from_chars(text.data() + 1, end, signal.selected_by);
  signal.multiplexing = text.back() == 'M' ? Multiplexing::kExtended : Multiplexing::kSelected;
  return stop == end && error == std::errc{} && signal.selected_by >= 0;
}

class Parser {
 public:
  Parser(std::string_view text, const std::string& file) : in_(text, file) { database_.file = file; }

  Database Parse() {
    while (!in_.AtEnd()) Statement();
    for (const auto& [raw_id, index] : by_raw_id_) attributes_.Apply(raw_id, database_.messages[index]);
    return std::move(database_);
  }

 private:
  std::uint32_t RawId(const std::string& what) {
    return static_cast<std::uint32_t>(in_.TakeInteger(what, 0, 0xFFFF'FFFF));
  }

  void Statement() {
    if (!in_.AtName()) in_.FailExpected("a statement such as BO_");
    const Token keyword = in_.Advance();
    if (keyword.text == "VERSION") {
      in_.Take(TokenKind::kString, "a version string after VERSION");
    } else if (keyword.text == "NS_") {
      NewSymbols();
    } else if (keyword.text == "BS_") {
      BitTiming();
    } else if (keyword.text == "BU_") {
      Nodes();
    } else if (keyword.text == "BO_") {
      MessageStatement(keyword.line);
    } else if (keyword.text == "SG_") {
      in_.Fail(keyword.line, "found SG_ outside a message: expected BO_ before it");
    } else if (keyword.text == "CM_") {
      Comment();
    } else if (keyword.text == "VAL_") {
      ValueNames();
    } else if (keyword.text == "SIG_VALTYPE_") {
      ValueTypeStatement();
    } else if (keyword.text == "SG_MUL_VAL_") {
      SelectingValues(keyword);
    } else if (keyword.text == "BA_DEF_") {
      attributes_.Define(Rest(keyword));
    } else if (keyword.text == "BA_DEF_DEF_") {
      attributes_.Default(Rest(keyword));
    } else if (keyword.text == "BA_") {
      attributes_.Set(Rest(keyword));
    } else {
      Rest(keyword);  // of no interest
    }
  }

  void NewSymbols() {
    in_.TakeMark(":", "after NS_");
    while (in_.AtName() && in_.Ahead().text != "BS_" && in_.Ahead().text != "BU_" &&
           in_.Ahead().text != "BO_") {
      in_.Advance();
    }
  }

  void BitTiming() {
    in_.TakeMark(":", "after BS_");
    while (in_.Ahead().kind == TokenKind::kNumber || in_.Ahead().kind == TokenKind::kMark) in_.Advance();
  }

  /// Names up to the next statement: a word with '_' at its end, first in its line.
  void Nodes() {
    int line = in_.Ahead().line;
    in_.TakeMark(":", "after BU_");
    while (in_.AtName() && (in_.Ahead().line == line || in_.Ahead().text.back() != '_')) {
      line = in_.Advance().line;
    }
    if (in_.AtMark(";")) in_.Advance();
  }

  void EndOfStatement(const std::string& keyword) { in_.TakeMark(";", "at the end of " + keyword); }

  /// Tokens up to ';'. A statement that runs into a message is a mistyped word, not to be passed over
  /// silently.
  std::vector<Token> Rest(const Token& keyword) {
    std::vector<Token> tokens;
    int line = keyword.line;
    while (!in_.AtMark(";")) {
      const bool message_begins = (in_.AtName("BO_") || in_.AtName("SG_")) && in_.Ahead().line != line;
      if (in_.AtEnd() || message_begins) {
        in_.Fail(keyword.line, "expected a statement with ';' at its end, found " + Describe(keyword) +
                                   " and then " + Describe(in_.Ahead()));
      }
      tokens.push_back(in_.Advance());
      line = tokens.back().end_line;
    }
    in_.Advance();
    return tokens;
  }

  void MessageStatement(int line) {
    Message message;
    message.line = line;
    const std::uint32_t raw_id = RawId("the message id after BO_");
    message.name = in_.Take(TokenKind::kName, "the message's name").text;
    in_.TakeMark(":", "after the message's name");
    message.size_bytes = static_cast<int>(in_.TakeInteger("the message's size in bytes", 0, kLargestSize));
    message.sender = in_.Take(TokenKind::kName, "the message's sender").text;
    while (in_.AtName("SG_")) {
      const int signal_line = in_.Advance().line;
      message.signals.push_back(SignalStatement(signal_line));
    }
    if (raw_id == kIndependentSignals) return;
    message.extended = (raw_id & kExtendedFlag) != 0;
    message.id = raw_id & ~kExtendedFlag;
    CheckNewMessage(database_, message);
    by_raw_id_[raw_id] = database_.messages.size();
    database_.messages.push_back(std::move(message));
  }

  Signal SignalStatement(int line) {
    Signal signal;
    signal.line = line;
    signal.name = in_.Take(TokenKind::kName, "the signal's name after SG_").text;
    if (in_.AtName()) {
      if (!ReadMultiplexing(in_.Ahead().text, signal)) {
        in_.FailExpected("':' or a multiplexing indicator (M, m0, m1, ...)");
      }
      in_.Advance();
    }
    in_.TakeMark(":", "after the signal's name");
    signal.start_bit = static_cast<int>(in_.TakeInteger("the signal's start bit", 0, 8 * kLargestSize - 1));
    in_.TakeMark("|", "after the start bit");
    signal.length_bits = static_cast<int>(in_.TakeInteger("the signal's length in bits", 1, kLongestSignal));
    in_.TakeMark("@", "after the length");
    signal.little_endian = in_.TakeInteger("the byte order: 0 (Motorola) or 1 (Intel)", 0, 1) == 1;
    if (!in_.AtMark("+") && !in_.AtMark("-")) in_.FailExpected("'+' (unsigned) or '-' (signed)");
    signal.is_signed = in_.Advance().text == "-";
    in_.TakeMark("(", "before the factor");
    signal.factor = in_.TakeNumber("the factor");
    if (signal.factor == 0.0)
      in_.Fail(line, "the factor of signal '" + signal.name + "' is 0 (decimals have a point, no comma)");
    in_.TakeMark(",", "after the factor");
    signal.offset = in_.TakeNumber("the offset");
    in_.TakeMark(")", "after the offset");
    in_.TakeMark("[", "before the minimum");
    signal.minimum = in_.TakeNumber("the minimum");
    in_.TakeMark("|", "after the minimum");
    signal.maximum = in_.TakeNumber("the maximum");
    in_.TakeMark("]", "after the maximum");
    const Token unit = in_.Take(TokenKind::kString, "the unit in quotes");
    signal.unit = unit.text;
    Receivers(unit.end_line);
    return signal;
  }

  /// Names with or without commas, to the end of the line or after a comma.
  void Receivers(int line) {
    bool after_comma = false;
    while (in_.Ahead().line == line || after_comma) {
      after_comma = in_.AtMark(",");
      if (!after_comma && !in_.AtName()) break;
      line = in_.Advance().line;
    }
  }

  void Comment() {
    std::string* target = nullptr;
    if (in_.AtName("BO_")) {
      in_.Advance();
      if (Message* message = Find(RawId("the message id after CM_ BO_"))) target = &message->comment;
    } else if (in_.AtName("SG_")) {
      in_.Advance();
      if (Signal* signal = TakeSignal("CM_ SG_")) target = &signal->comment;
    } else if (in_.AtName()) {  // BU_, EV_: a name follows
      in_.Advance();
      in_.Take(TokenKind::kName, "a name before the comment");
    }
    std::string text = in_.Take(TokenKind::kString, "the comment in quotes").text;
    EndOfStatement("CM_");
    if (target != nullptr) *target = std::move(text);
  }

  void ValueNames() {
    Signal* signal = nullptr;
    if (in_.Ahead().kind == TokenKind::kNumber) {
      signal = TakeSignal("VAL_");
    } else {
      in_.Take(TokenKind::kName, "a message id or an environment variable after VAL_");
    }
    while (in_.Ahead().kind == TokenKind::kNumber) {
      const std::int64_t value = in_.TakeRawValue();
      std::string name = in_.Take(TokenKind::kString, "the value's name in quotes").text;
      if (signal != nullptr) signal->value_names[value] = std::move(name);
    }
    EndOfStatement("VAL_");
  }

  void ValueTypeStatement() {
    Signal* signal = TakeSignal("SIG_VALTYPE_");
    if (in_.AtMark(":")) in_.Advance();
    const std::int64_t type = in_.TakeInteger("0 (integer), 1 (float) or 2 (double)", 0, 2);
    EndOfStatement("SIG_VALTYPE_");
    if (signal != nullptr) signal->type = static_cast<ValueType>(type);
  }

  /// "id signal selector 3-3;": tools repeat here what m3 says. Several values, or a selector that is
  /// selected itself, are extended multiplexing.
  void SelectingValues(const Token& keyword) {
    Signal* signal = TakeSignal("SG_MUL_VAL_");
    const std::vector<Token> rest = Rest(keyword);
    if (signal == nullptr || signal->multiplexing != Multiplexing::kSelected) return;
    const std::string value = std::to_string(signal->selected_by);
    const bool one_value = rest.size() == 3 && rest[1].text == value && rest[2].text == "-" + value;
    if (!one_value) signal->multiplexing = Multiplexing::kExtended;
  }

  /// Comments and value names may speak of what is not there: such leftovers are common and harmless.
  Message* Find(std::uint32_t raw_id) {
    const auto found = by_raw_id_.find(raw_id);
    return found == by_raw_id_.end() ? nullptr : &database_.messages[found->second];
  }
  Signal* TakeSignal(const std::string& keyword) {
    Message* message = Find(RawId("the message id after " + keyword));
    const Token name = in_.Take(TokenKind::kName, "the signal's name in " + keyword);
    if (message == nullptr) return nullptr;
    const auto at = std::find_if(message->signals.begin(), message->signals.end(),
                                 [&](const Signal& signal) { return signal.name == name.text; });
    return at == message->signals.end() ? nullptr : &*at;
  }

  DbcTokens in_;
  Database database_;
  DbcAttributes attributes_;
  std::map<std::uint32_t, std::size_t> by_raw_id_;
};

}  // namespace

namespace {

/// Lines may end in LF, CR LF or CR.
std::string WithLineFeeds(const std::string& text) {
  std::string lines;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\r' && i + 1 < text.size() && text[i + 1] == '\n') continue;
    lines += text[i] == '\r' ? '\n' : text[i];
  }
  return lines;
}

}  // namespace

Database ParseDbc(std::string_view text, const std::string& file) {
  const std::string utf8 = WithLineFeeds(ToUtf8(text));
  return Parser(utf8, file).Parse();
}

}  // namespace servohil::can
