#include "signal_map/names.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "base/error.hpp"
#include "base/nearest_name.hpp"
#include "can/dbc/codec.hpp"

namespace servohil::signal_map {
namespace {

std::string Trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

}  // namespace

Reference ParseReference(const std::string& text, const std::string& place) {
  const std::size_t equals = text.find('=');
  const std::string name = Trimmed(text.substr(0, equals));
  const std::size_t dot = name.find('.');
  Reference reference{name.substr(0, dot), dot == std::string::npos ? "" : name.substr(dot + 1), {}};
  if (equals != std::string::npos) reference.value = Trimmed(text.substr(equals + 1));
  const bool value_missing = equals != std::string::npos && reference.value.empty();
  if (reference.message.empty() || reference.signal.empty() || value_missing)
    throw base::UsageError(place + "must be \"MESSAGE.SIGNAL\"" +
                           (equals == std::string::npos ? "" : " or \"MESSAGE.SIGNAL = VALUE\""));
  return reference;
}

can::Databases::Found FindMessage(const can::Databases& databases, const std::string& name,
                                  const std::string& place) {
  try {
    return databases.RequireMessage(name);
  } catch (const base::UsageError& error) {
    throw base::UsageError(place + error.what());
  }
}

FoundSignal FindSignal(const can::Databases& databases, const Reference& reference,
                       const std::string& place) {
  const auto [database, message] = FindMessage(databases, reference.message, place);
  try {
    return {database, message, &database->RequireSignal(*message, reference.signal)};
  } catch (const base::UsageError& error) {
    throw base::UsageError(place + error.what());
  }
}

namespace {

/// Another name of the same bits; empty: there is none.
std::string OtherNameOf(const can::Signal& signal, std::int64_t raw, const std::string& name) {
  for (const auto& [number, other] : signal.value_names) {
    if (other != name && can::RawInField(signal, number) == raw) return other;
  }
  return {};
}

}  // namespace

std::vector<std::int64_t> RawValuesOf(const FoundSignal& found, const std::string& value,
                                      const std::string& place) {
  const can::Signal& signal = *found.signal;
  const auto never = [&](const std::string& what) {
    throw base::UsageError(place + found.Place() + found.Name() + " has " +
                           std::to_string(signal.length_bits) + " bits and is never " + what);
  };
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error == std::errc{} && end == value.data() + value.size()) {
    const std::optional<std::int64_t> raw = can::RawInField(signal, number);
    if (!raw) never(value);
    return {*raw};
  }
  std::vector<std::string> names;
  std::vector<std::int64_t> numbers;
  for (const auto& [of_name, name] : signal.value_names) {
    if (name == value) numbers.push_back(of_name);
    names.push_back(name);
  }
  if (numbers.empty()) {
    const std::string nearest = base::NearestName(value, names);
    throw base::UsageError(
        place + found.Place() + found.Name() + " has no value \"" + value + "\" in its VAL_" +
        (nearest.empty() ? "; a raw number will do" : "; the nearest is \"" + nearest + "\""));
  }
  std::vector<std::int64_t> raws;
  for (const std::int64_t one : numbers) {
    const std::optional<std::int64_t> raw = can::RawInField(signal, one);
    if (!raw) continue;
    if (const std::string other = OtherNameOf(signal, *raw, value); !other.empty()) {
      throw base::UsageError(place + found.Place() + found.Name() + ": \"" + value + "\" and \"" + other +
                             "\" are the same bits (" + std::to_string(*raw) + "); a raw number will do");
    }
    if (std::find(raws.begin(), raws.end(), *raw) == raws.end()) raws.push_back(*raw);
  }
  if (raws.empty()) never("\"" + value + "\" (" + std::to_string(numbers.front()) + ")");
  return raws;
}

Linear ConversionOf(const FoundSignal& found, const std::string& unit, const std::string& quantity_unit,
                    bool to_signal, const std::string& place) {
  const std::string& of_signal = unit.empty() ? found.signal->unit : unit;
  const auto conversion =
      to_signal ? Conversion(quantity_unit, of_signal) : Conversion(of_signal, quantity_unit);
  if (conversion) return *conversion;
  const std::string known = ConvertibleUnits(quantity_unit);
  const std::string expected = known.empty() ? "\"" + quantity_unit + "\"" : "one of " + known;
  const std::string what = unit.empty() ? found.Name() + " has the unit \"" + of_signal + "\""
                                        : found.Name() + ": the unit \"" + unit + "\" is not known here";
  throw base::UsageError(place + found.Place() + what + ", expected " + expected +
                         "; else give `unit` where that is what it means, or `scale = [[x, y], [x, y]]`");
}

Linear LineThrough(const configuration::Scale& scale, const std::string& place) {
  if (scale.size() != 2 || scale[0].from == scale[1].from || scale[0].to == scale[1].to)
    throw base::UsageError(place + "must be two different points, as [[4.0, 0.0], [20.0, 150.0]]");
  const double slope = (scale[1].to - scale[0].to) / (scale[1].from - scale[0].from);
  return {slope, scale[0].to - slope * scale[0].from};
}

Range RangeOf(const can::Signal& signal) {
  double low = -std::numeric_limits<double>::infinity();
  double high = -low;
  if (signal.type == can::ValueType::kInteger) {
    const int magnitude_bits = signal.is_signed ? signal.length_bits - 1 : signal.length_bits;
    const double raw_low = signal.is_signed ? -std::ldexp(1.0, magnitude_bits) : 0.0;
    const double raw_high = std::ldexp(1.0, magnitude_bits) - 1.0;
    low = std::min(raw_low * signal.factor, raw_high * signal.factor) + signal.offset;
    high = std::max(raw_low * signal.factor, raw_high * signal.factor) + signal.offset;
  }
  if (signal.minimum < signal.maximum) return {std::max(low, signal.minimum), std::min(high, signal.maximum)};
  return {low, high};
}

}  // namespace servohil::signal_map
