#include "signal_map/names.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

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

std::int64_t RawValueOf(const FoundSignal& found, const std::string& value, const std::string& place) {
  std::int64_t raw = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), raw);
  if (error == std::errc{} && end == value.data() + value.size()) {
    std::array<std::uint8_t, 64> data{};
    can::InsertRaw(*found.signal, raw, data);
    if (can::ExtractRaw(*found.signal, data) == raw) return raw;
    throw base::UsageError(place + found.Place() + found.Name() + " has " +
                           std::to_string(found.signal->length_bits) + " bits and is never " + value);
  }
  std::vector<std::string> names;
  for (const auto& [number, name] : found.signal->value_names) {
    if (name == value) return number;
    names.push_back(name);
  }
  const std::string nearest = base::NearestName(value, names);
  throw base::UsageError(
      place + found.Place() + found.Name() + " has no value \"" + value + "\" in its VAL_" +
      (nearest.empty() ? "; a raw number will do" : "; the nearest is \"" + nearest + "\""));
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
