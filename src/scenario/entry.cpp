#include "scenario/entry.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/formatted.hpp"
#include "base/nearest_name.hpp"
#include "configuration/toml_text.hpp"

namespace servohil::scenario {

namespace {

constexpr double kUnlimited = 1e12;

/// "a number from 0 to 3 s"
std::string NumberWithin(double minimum, double maximum, const std::string& unit) {
  const std::string end = unit.empty() ? "" : " " + unit;
  if (minimum <= -kUnlimited) return "must be a number" + (unit.empty() ? "" : " of " + unit);
  if (maximum >= kUnlimited) return base::Formatted("must be a number, at least %g", minimum) + end;
  return base::Formatted("must be a number from %g to %g", minimum, maximum) + end;
}

}  // namespace

std::string Entry::PlaceOf(const std::string& key) const {
  const toml::node* node = table_.get(key);
  const auto line = node != nullptr ? node->source().begin.line : table_.source().begin.line;
  return file_ + ":" + std::to_string(line);
}

void Entry::Fail(const std::string& key, const std::string& right) const {
  const toml::node* node = table_.get(key);
  if (node != nullptr)
    throw base::UsageError(PlaceOf(key) + ": " + what_ + " " + key + " = " + configuration::Shown(*node) +
                           ": " + right);
  std::vector<std::string> others;
  for (const auto& [name, value] : table_) {
    if (std::find(known_.begin(), known_.end(), name.str()) == known_.end()) others.emplace_back(name.str());
  }
  const std::string written = base::NearestName(key, others);
  if (!written.empty())
    throw base::UsageError(PlaceOf(written) + ": " + what_ + " has no key " + written + "; did you mean " +
                           key + "?");
  throw base::UsageError(PlaceOf(key) + ": " + what_ + " has no " + key + ": it " + right);
}

void Entry::FailWhole(const std::string& what_is_wrong) const {
  throw base::UsageError(PlaceOf("") + ": " + what_ + ": " + what_is_wrong);
}

const toml::node* Entry::Any(const std::string& key) {
  known_.push_back(key);
  return table_.get(key);
}

std::optional<double> Entry::Number(const std::string& key, double minimum, double maximum,
                                    const std::string& unit) {
  const toml::node* node = Any(key);
  if (node == nullptr) return {};
  const bool is_number = node->is_floating_point() || node->is_integer();
  const double value = node->value<double>().value_or(0.0);
  if (!is_number || !(value >= minimum && value <= maximum)) {
    Fail(key, NumberWithin(minimum, maximum, unit));
  }
  return value;
}

double Entry::RequireNumber(const std::string& key, double minimum, double maximum, const std::string& unit) {
  if (!Has(key)) Fail(key, NumberWithin(minimum, maximum, unit));
  return *Number(key, minimum, maximum, unit);
}

std::optional<std::string> Entry::Text(const std::string& key) {
  const toml::node* node = Any(key);
  if (node == nullptr) return {};
  auto text = node->value_exact<std::string>();
  if (!text || text->empty()) Fail(key, "must be a text in quotes");
  return text;
}

std::string Entry::RequireText(const std::string& key) {
  if (!Has(key)) Fail(key, "must be a text in quotes");
  return *Text(key);
}

std::optional<std::pair<double, double>> Entry::Range(const std::string& key, double minimum, double maximum,
                                                      const std::string& unit) {
  const toml::node* node = Any(key);
  if (node == nullptr) return {};
  const toml::array* both = node->as_array();
  if (both != nullptr && both->size() == 2) {
    const auto low = both->get(0)->value<double>();
    const auto high = both->get(1)->value<double>();
    if (low && high && minimum <= *low && *low <= *high && *high <= maximum) return {{*low, *high}};
  }
  Fail(key,
       base::Formatted("must be [LOWEST, HIGHEST], each from %g to %g %s", minimum, maximum, unit.c_str()));
}

void Entry::RefuseOthers() const {
  for (const auto& [name, node] : table_) {
    const std::string key(name.str());
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    throw base::UsageError(PlaceOf(key) + ": " + what_ + " has no key " + key + "; " +
                           base::DidYouMean(key, known_, "it has " + base::Listed(known_)));
  }
}

}  // namespace servohil::scenario
