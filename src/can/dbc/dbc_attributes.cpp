#include "can/dbc/dbc_attributes.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <system_error>

namespace servohil::can {
namespace {

constexpr int kClassicalBytes = 8;
constexpr double kLongestCycleMs = 86'400'000.0;  // one day: anything above is no cycle time

bool IsName(const Token& token, const char* name) {
  return token.kind == TokenKind::kName && token.text == name;
}

std::optional<double> NumberIn(const std::string& text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

void DbcAttributes::Define(Statement statement) {
  // [BU_|BO_|SG_|EV_] "Name" ENUM "first","second",...
  if (!statement.empty() && statement[0].kind == TokenKind::kName) statement = statement.subspan(1);
  if (statement.size() < 2 || statement[0].kind != TokenKind::kString || !IsName(statement[1], "ENUM"))
    return;
  std::vector<std::string>& names = enumerations_[statement[0].text];
  names.clear();
  for (const Token& token : statement.subspan(2)) {
    if (token.kind == TokenKind::kString) names.push_back(token.text);
  }
}

void DbcAttributes::Default(Statement statement) {
  if (statement.size() == 2 && statement[0].kind == TokenKind::kString) {
    defaults_[statement[0].text] = statement[1].text;
  }
}

void DbcAttributes::Set(Statement statement) {
  // "Name" BO_ id value, or "Name" SG_ id signal value
  const bool of_message = statement.size() == 4 && IsName(statement[1], "BO_");
  const bool of_signal = statement.size() == 5 && IsName(statement[1], "SG_");
  if (!of_message && !of_signal) return;
  const double id = NumberIn(statement[2].text).value_or(-1.0);
  if (id < 0.0 || id > 0xFFFF'FFFF) return;
  values_[{statement[0].text, static_cast<std::uint32_t>(id), of_signal ? statement[3].text : ""}] =
      statement.back().text;
}

std::string DbcAttributes::ValueOf(const std::string& attribute, std::uint32_t raw_id,
                                   const std::string& signal) const {
  const auto enumeration = enumerations_.find(attribute);
  const auto set = values_.find({attribute, raw_id, signal});
  const auto otherwise = defaults_.find(attribute);
  if (set == values_.end() && otherwise == defaults_.end()) return {};
  const std::string& text = set != values_.end() ? set->second : otherwise->second;
  if (enumeration == enumerations_.end()) return text;
  // Enumerated values are written as index or as name, defaults as well.
  const auto& names = enumeration->second;
  if (std::find(names.begin(), names.end(), text) != names.end() && set == values_.end()) return text;
  const double index = NumberIn(text).value_or(-1.0);
  const bool is_index = index >= 0.0 && index < static_cast<double>(names.size());
  return is_index ? names[static_cast<std::size_t>(index)] : text;
}

double DbcAttributes::NumberOf(const std::string& attribute, std::uint32_t raw_id,
                               const std::string& signal) const {
  return NumberIn(ValueOf(attribute, raw_id, signal)).value_or(0.0);
}

std::string DbcAttributes::FrameFormatOf(std::uint32_t raw_id) const {
  std::string text = ValueOf("VFrameFormat", raw_id, "");
  const std::optional<double> number = NumberIn(text);  // where the attribute is an INT: Vector's numbers
  if (number == 3.0) return "J1939PG";
  if (number == 14.0) return "StandardCAN_FD";
  if (number == 15.0) return "ExtendedCAN_FD";
  return text;
}

void DbcAttributes::Apply(std::uint32_t raw_id, Message& message) const {
  const std::string format = FrameFormatOf(raw_id);
  message.fd =
      format == "StandardCAN_FD" || format == "ExtendedCAN_FD" || message.size_bytes > kClassicalBytes;
  message.j1939 = format == "J1939PG";
  message.bit_rate_switch = message.fd && ValueOf("CANFD_BRS", raw_id, "") == "1";
  message.cycle_ms =
      static_cast<int>(std::clamp(NumberOf("GenMsgCycleTime", raw_id, ""), 0.0, kLongestCycleMs));
  for (Signal& signal : message.signals) {
    signal.start_raw = NumberOf("GenSigStartValue", raw_id, signal.name);
  }
}

}  // namespace servohil::can
