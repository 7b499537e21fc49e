#include "thesis/entry.hpp"

#include <cctype>
#include <cmath>

#include "base/formatted.hpp"

namespace servohil::thesis {
namespace {

bool Meets(const std::string& text, double ours) {
  // A value exactly half a digit away rounds either way.
  return std::fabs(ours - std::stod(text)) <= HalfDigit(text) * (1.0 + 1e-9);
}

/// "Stable, lightly damped" says stable.
std::string FirstWord(const std::string& text) {
  std::string word;
  for (const char c : text) {
    if (std::isalpha(static_cast<unsigned char>(c)) == 0) break;
    word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return word;
}

}  // namespace

double HalfDigit(const std::string& printed) {
  const std::size_t exponent = printed.find('e');
  const std::string mantissa = printed.substr(0, exponent);
  const std::size_t point = mantissa.find('.');
  const int decimals = point == std::string::npos ? 0 : static_cast<int>(mantissa.size() - point - 1);
  const int power = exponent == std::string::npos ? 0 : std::stoi(printed.substr(exponent + 1));
  return 0.5 * std::pow(10.0, power - decimals);
}

Status Entry::Judge() const {
  const auto meets = [&](const std::string& text) {
    return IsWord() ? FirstWord(text) == FirstWord(ours_word) : Meets(text, ours);
  };
  if (meets(printed)) return Status::kAgrees;
  return reason && meets(reason->right) ? Status::kExplained : Status::kUnexplained;
}

std::string Entry::Ours() const {
  if (IsWord()) return ours_word;
  return base::Formatted("%.6g", ours);
}

std::string Entry::Deviation() const {
  if (IsWord()) return "";
  const double value = std::stod(printed);
  return base::Formatted("%+.2f %%", 100.0 * (ours - value) / std::fabs(value));
}

}  // namespace servohil::thesis
