#pragma once
/// The two ways a start-up can fail. The text is one line for the user: what, where, and what would be right.

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

namespace servohil::base {

/// Whatever a file has put into it, such as line ends and a terminal's escapes.
inline std::string OneLine(std::string text) {
  const auto is_control = [](char c) { return (c >= 0 && c < ' ') || c == '\x7f'; };
  std::replace_if(text.begin(), text.end(), is_control, ' ');
  return text;
}

/// Wrong usage, configuration or input file: exit status 2.
struct UsageError : std::runtime_error {
  explicit UsageError(const std::string& text) : std::runtime_error(OneLine(text)) {}
  /// Several mistakes, a line for each.
  explicit UsageError(const std::vector<std::string>& mistakes) : std::runtime_error(Lines(mistakes)) {}

 private:
  static std::string Lines(const std::vector<std::string>& mistakes) {
    std::string all;
    for (const std::string& one : mistakes) all += (all.empty() ? "" : "\n") + OneLine(one);
    return all;
  }
};

/// The machine lacks something (interface, permission, device): exit status 3.
struct EnvironmentError : std::runtime_error {
  explicit EnvironmentError(const std::string& text) : std::runtime_error(OneLine(text)) {}
};

}  // namespace servohil::base
