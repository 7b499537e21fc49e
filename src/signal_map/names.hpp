#pragma once
/// Looking up what the configuration names, with errors that say where it is named and where it is defined.

#include <optional>
#include <string>

#include "can/dbc/dbc.hpp"
#include "configuration/signal_map_settings.hpp"
#include "signal_map/unit.hpp"

namespace servohil::signal_map {

/// A signal with the message and file that it is of.
struct FoundSignal {
  const can::Database* database = nullptr;
  const can::Message* message = nullptr;
  const can::Signal* signal = nullptr;

  std::string Name() const { return message->name + "." + signal->name; }
  std::string Place() const { return database->file + ":" + std::to_string(signal->line) + ": "; }
};

/// "MESSAGE.SIGNAL", or "MESSAGE.SIGNAL = VALUE" with a raw value or a name of it (VAL_).
struct Reference {
  std::string message;
  std::string signal;
  std::string value;  ///< empty: none given
};

/// @throws UsageError, `place` before it, which is "FILE:LINE: KEY = TEXT: "
Reference ParseReference(const std::string& text, const std::string& place);
FoundSignal FindSignal(const can::Databases& databases, const Reference& reference, const std::string& place);
can::Databases::Found FindMessage(const can::Databases& databases, const std::string& name,
                                  const std::string& place);
/// Returns every raw value that `value` stands for, a number or a name in VAL_, as ExtractRaw() gives it:
/// modulo the width of the field, so that 1 in a signed field of one bit is -1. At least one.
/// @throws UsageError where no such value can be in the field, and where two names are the same bits
std::vector<std::int64_t> RawValuesOf(const FoundSignal& found, const std::string& value,
                                      const std::string& place);

/// From a value in `from` (the signal's unit, or the quantity's) to one in `to`. `unit`, where it is not
/// empty, takes the place of the signal's own.
Linear ConversionOf(const FoundSignal& found, const std::string& unit, const std::string& quantity_unit,
                    bool to_signal, const std::string& place);
/// @throws UsageError unless it has two different points
Linear LineThrough(const configuration::Scale& scale, const std::string& place);

/// Physical values that the signal can hold, within its stated range where it has one.
struct Range {
  double low;
  double high;
};
Range RangeOf(const can::Signal& signal);

}  // namespace servohil::signal_map
