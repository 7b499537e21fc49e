#include "configuration/toml_error.hpp"

#include <algorithm>
#include <array>

namespace servohil::configuration {
namespace {

struct Advice {
  std::string_view said;  ///< part of what toml++ says
  std::string_view advice;
};
constexpr std::array kAdvice = std::to_array<Advice>({
    {"could not determine value type", "a text stands in quotes"},
    {"unescaped control characters", "is a closing quote missing?"},
    {"saw 'T'", "true and false are written in small letters"},
    {"saw 'F'", "true and false are written in small letters"},
    {"unicode scalar", "a backslash begins an escape: write / or 'single quotes'"},
    {"escape sequence", "a backslash begins an escape: write / or 'single quotes'"},
    {"invalid utf-8", "save the file as UTF-8"},
    {"existing table", "each table stands once; lists of tables have double brackets: [[can.publish]]"},
});

std::string AdviceFor(std::string_view description) {
  const auto* const found = std::find_if(kAdvice.begin(), kAdvice.end(), [&](const Advice& one) {
    return description.find(one.said) != std::string_view::npos;
  });
  return found == kAdvice.end() ? std::string() : ": " + std::string(found->advice);
}

/// One line of the text, without its indentation; 1 is the first.
std::string LineOf(std::string_view text, std::uint32_t number) {
  for (; number > 1; --number) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return {};
    text.remove_prefix(end + 1);
  }
  text = text.substr(0, text.find_first_of("\r\n"));
  const std::size_t begin = text.find_first_not_of(" \t");
  return begin == std::string_view::npos ? std::string() : std::string(text.substr(begin));
}

/// "Error while parsing value: could not ..." → "could not ..."
std::string_view Core(std::string_view description) {
  constexpr std::string_view kBegin = "Error while parsing ";
  if (description.substr(0, kBegin.size()) != kBegin) return description;
  const std::size_t colon = description.find(": ");
  return colon == std::string_view::npos ? description : description.substr(colon + 2);
}

}  // namespace

std::string DescribeTomlError(const toml::parse_error& error, std::string_view text,
                              const std::string& file) {
  const std::uint32_t line = error.source().begin.line;
  std::string place = file;
  if (line != 0) place += ":" + std::to_string(line);
  constexpr std::size_t kMaxShown = 80;
  const bool is_text = error.description().find("utf-8") == std::string_view::npos;
  const std::string shown = is_text ? LineOf(text, line).substr(0, kMaxShown) : std::string();
  return place + ": " + (shown.empty() ? "" : shown + ": ") + std::string(Core(error.description())) +
         AdviceFor(error.description());
}

}  // namespace servohil::configuration
