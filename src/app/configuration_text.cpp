#include "servohil/app/configuration_text.hpp"

#include <array>
#include <charconv>
#include <string_view>
#include <type_traits>
#include <variant>

#include "formatted.hpp"

namespace servohil::app {
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
      quoted += Formatted("\\u%04X", unsigned{code});
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

/// A value as TOML.
struct AsToml {
  /// The shortest decimal that is read back as the same number.
  std::string operator()(double v) const {
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), v).ptr;
    return {text.data(), end};
  }
  std::string operator()(int v) const { return std::to_string(v); }
  std::string operator()(bool v) const { return v ? "true" : "false"; }
  std::string operator()(const std::string& v) const { return Quoted(v); }
  std::string operator()(const std::vector<std::string>& v) const {
    std::string text = "[";
    for (const std::string& item : v) text += (text.size() > 1 ? ", " : "") + Quoted(item);
    return text + "]";
  }
  template <typename Enum>
  requires std::is_enum_v<Enum> std::string operator()(Enum v) const {
    return Quoted(NamesOf(v)[static_cast<std::size_t>(v)]);
  }
};

}  // namespace

std::string ConfigurationToml(const Configuration& configuration) {
  Configuration c = configuration;
  c.load_file = kLoadFileName;
  if (!c.load_closing_file.empty()) c.load_closing_file = kLoadClosingFileName;
  c.can.dbc = kDbcFileName;

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
    text += std::visit([&](auto place) { return AsToml{}(place(c)); }, key.place);
    if (*key.unit != 0) text += std::string("  # ") + key.unit;
    text += '\n';
  }
  return text;
}

}  // namespace servohil::app
