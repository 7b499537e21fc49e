#include "configuration/toml_text.hpp"

#include <array>
#include <charconv>
#include <sstream>

#include "base/error.hpp"

namespace servohil::configuration {

std::string Shown(const toml::node& node) {
  if (const auto number = node.value_exact<double>()) {  // toml++ writes 0.1 as 0.10000000000000001
    std::array<char, 32> digits{};
    return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), *number).ptr};
  }
  std::ostringstream out;
  node.visit([&](const auto& value) { out << value; });
  return base::OneLine(out.str());
}

std::string AsToml(const toml::node& node) {
  std::ostringstream out;
  out << toml::toml_formatter(node, toml::format_flags::none);
  return out.str();
}

}  // namespace servohil::configuration
