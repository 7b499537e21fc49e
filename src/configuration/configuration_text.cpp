#include "configuration/configuration_text.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <string_view>
#include <type_traits>
#include <variant>

#include "base/formatted.hpp"

namespace servohil::configuration {
namespace {

/// A TOML basic string.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    constexpr unsigned char kFirstPrintable = 0x20;
    constexpr unsigned char kDelete = 0x7F;
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (code < kFirstPrintable || code == kDelete) {
      quoted += base::Formatted("\\u%04X", unsigned{code});
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

/// A value as TOML.
struct TomlOf {
  /// The shortest decimal that is read back as the same number. Without an exponent a large one would be read
  /// as an integer, of which TOML has 64 bits.
  std::string operator()(double v) const {
    constexpr double kLargest = 1e15;
    std::array<char, 32> text{};
    char* const begin = text.data();
    char* const most = begin + text.size();
    const bool large = std::isfinite(v) && std::abs(v) >= kLargest;
    return {begin, (large ? std::to_chars(begin, most, v, std::chars_format::scientific)
                          : std::to_chars(begin, most, v))
                       .ptr};
  }
  std::string operator()(int v) const { return std::to_string(v); }
  std::string operator()(bool v) const { return v ? "true" : "false"; }
  std::string operator()(const std::string& v) const { return Quoted(v); }
  std::string operator()(const std::vector<std::string>& v) const {
    std::string text = "[";
    for (const std::string& item : v) text += (text.size() > 1 ? ", " : "") + Quoted(item);
    return text + "]";
  }
  std::string operator()(const Scale& v) const {
    std::string text = "[";
    for (const ScalePoint& p : v)
      text += (text.size() > 1 ? ", [" : "[") + (*this)(p.from) + ", " + (*this)(p.to) + "]";
    return text + "]";
  }
  template <typename Enum>
  requires std::is_enum_v<Enum> std::string operator()(Enum v) const {
    return Quoted(NamesOf(v)[static_cast<std::size_t>(v)]);
  }
};

std::string SignalToml(const SignalSettings& signal) {
  if (signal.constant) return TomlOf{}(*signal.constant);
  if (signal.raw) return "{ raw = " + std::to_string(*signal.raw) + " }";
  std::string text = "{ quantity = " + Quoted(signal.quantity);
  if (!signal.unit.empty()) text += ", unit = " + Quoted(signal.unit);
  if (!signal.scale.empty()) text += ", scale = " + TomlOf{}(signal.scale);
  if (signal.may_clip) text += ", may_clip = true";
  return text + " }";
}

std::string ProtectionToml(const ProtectionSettings& protection) {
  if (protection.profile == can::E2eProfile::kNone) return {};
  std::string text = "e2e = " + TomlOf{}(protection.profile) + '\n';
  if (protection.data_id != can::kNoDataId) text += "data_id = " + std::to_string(protection.data_id) + '\n';
  text += "data_id_mode = " + TomlOf{}(protection.data_id_mode) + '\n';
  if (!protection.counter.empty()) text += "counter = " + Quoted(protection.counter) + '\n';
  if (!protection.checksum.empty()) text += "checksum = " + Quoted(protection.checksum) + '\n';
  return text;
}

std::string PublishedToml(const MessageSettings& message) {
  std::string text = "[[can.publish]]\nmessage = " + Quoted(message.message) + '\n';
  if (message.cycle_ms != 0) text += "cycle_ms = " + std::to_string(message.cycle_ms) + "\n";
  if (message.on_change) text += "on_change = true\n";
  text += ProtectionToml(message.protection);
  if (!message.signals.empty()) text += "[can.publish.signals]\n";
  for (const SignalSettings& signal : message.signals)
    text += signal.signal + " = " + SignalToml(signal) + '\n';
  return text;
}

}  // namespace

std::string DbcFileName(std::size_t index) {
  return index == 0 ? "servohil.dbc" : "servohil-" + std::to_string(index + 1) + ".dbc";
}

std::string ValueToml(const Key& key, Configuration& configuration) {
  return std::visit([&](auto place) { return TomlOf{}(place(configuration)); }, key.place);
}

std::string ConfigurationToml(const Configuration& configuration) {
  Configuration c = configuration;
  c.load_file = kLoadFileName;
  if (!c.load_closing_file.empty()) c.load_closing_file = kLoadClosingFileName;
  for (std::size_t i = 0; i < c.can.dbc.size(); ++i) c.can.dbc[i] = DbcFileName(i);

  std::string text;
  std::string_view section;
  for (const Key& key : KeyTable()) {
    const std::string_view name = key.name;
    const std::size_t dot = name.rfind('.');
    if (name.substr(0, dot) != section) {
      section = name.substr(0, dot);
      text += (text.empty() ? "[" : "\n[") + std::string(section) + "]\n";
    }
    text += std::string(name.substr(dot + 1)) + " = ";
    text += ValueToml(key, c);
    if (*key.unit != 0) text += std::string("  # ") + key.unit;
    text += '\n';
  }
  for (const MessageSettings& message : c.can.publish) text += '\n' + PublishedToml(message);
  return text;
}

}  // namespace servohil::configuration
