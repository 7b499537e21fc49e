/// The published messages: what fills each of their bits.

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>

#include "base/error.hpp"
#include "base/formatted.hpp"
#include "base/nearest_name.hpp"
#include "can/dbc/codec.hpp"
#include "model/ticks.hpp"
#include "signal_map/binding.hpp"
#include "signal_map/names.hpp"

namespace servohil::signal_map {
namespace {

constexpr std::uint8_t kJ1939Unused = 0xFF;  // SAE J1939-71: what is not defined is all ones

struct DefaultMessage {
  const char* name;
  int configuration::PublishSettings::*cycle_ms;
};
/// servohil's own, whose signals have the names of quantities.
constexpr std::array kDefaultMessages = std::to_array<DefaultMessage>({
    {"SERVO_Position", &configuration::PublishSettings::position_ms},
    {"SERVO_Pressures", &configuration::PublishSettings::pressures_ms},
    {"SERVO_Relay", &configuration::PublishSettings::relay_ms},
    {"SERVO_Bus", &configuration::PublishSettings::bus_ms},
    {"SERVO_Safety", &configuration::PublishSettings::safety_ms},
    {"SERVO_Status", &configuration::PublishSettings::status_ms},
});

std::vector<configuration::MessageSettings> MessagesOf(const configuration::Configuration& configuration) {
  if (!configuration.can.publish.empty()) return configuration.can.publish;
  std::vector<configuration::MessageSettings> messages;
  for (const DefaultMessage& one : kDefaultMessages) {
    const int cycle_ms = configuration.publish.*one.cycle_ms;
    if (cycle_ms != 0) messages.push_back({one.name, cycle_ms, false, {}, {}, {}});
  }
  return messages;
}

bool IsMeasured(const simulation::Quantity& quantity) {
  const std::string_view unit = quantity.unit;
  return unit == "in" || unit == "in/s" || unit == "psi";
}

std::string AllSignals() {
  std::vector<std::string> names;
  for (const simulation::Quantity& quantity : simulation::Quantities()) names.emplace_back(quantity.signal);
  return base::Listed(names);
}

/// What a signal starts with; beyond what it holds: the nearest.
void InsertStart(const can::Signal& signal, std::span<std::uint8_t> data) {
  if (signal.type != can::ValueType::kInteger) {
    can::Encode(signal, signal.start_raw * signal.factor + signal.offset, data);
    return;
  }
  const double largest = signal.is_signed ? 0x1p63 : 0x1p64;
  const double raw =
      std::clamp(signal.start_raw, signal.is_signed ? -0x1p63 : 0.0, std::nextafter(largest, 0.0));
  can::InsertRaw(signal,
                 signal.is_signed ? static_cast<std::int64_t>(raw)
                                  : static_cast<std::int64_t>(static_cast<std::uint64_t>(raw)),
                 data);
}

class MessageBinder {
 public:
  MessageBinder(const can::Databases& databases, const configuration::Configuration& configuration,
                const configuration::MessageSettings& settings)
      : configuration_(configuration),
        settings_(settings),
        place_(settings.place.empty() ? "no [[can.publish]]: " : settings.place + ": "),
        found_(FindMessage(databases, settings.message, place_)) {}

  PublishedMessage Bind() {
    PublishedMessage outgoing{found_.database, found_.message, CycleMs(), settings_.on_change, {}, {},
                              place_};
    outgoing.protection = BindProtection(*found_.database, *found_.message, settings_.protection,
                                         [&](const std::string&) { return place_; });
    for (const configuration::SignalSettings& signal : SignalsOf()) Bind(signal);
    NumberFields();
    for (const std::optional<std::int64_t> value : PageValues()) outgoing.pages.push_back(PageOf(value));
    return outgoing;
  }

 private:
  /// A signal with what it carries: a field, or a constant.
  struct Bound {
    const can::Signal* signal;
    std::optional<Field> field;
    std::optional<double> constant;
    std::optional<long long> raw;
  };

  std::string At(int line) const { return found_.database->file + ":" + std::to_string(line) + ": "; }

  int CycleMs() const {
    const can::Message& message = *found_.message;
    const int cycle_ms = settings_.cycle_ms != 0 ? settings_.cycle_ms : message.cycle_ms;
    if (cycle_ms == 0)
      throw base::UsageError(place_ + At(message.line) + message.name +
                             " has no cycle time (GenMsgCycleTime): give cycle_ms");
    if (cycle_ms * model::kTicksPerMs >= configuration_.loop.wake_ticks) return cycle_ms;
    throw base::UsageError(place_ + message.name + ": cycle_ms = " + std::to_string(cycle_ms) +
                           ": must be at least the wake period, loop.wake_ticks = " +
                           std::to_string(configuration_.loop.wake_ticks) + " ticks of 0.1 ms");
  }

  std::vector<configuration::SignalSettings> SignalsOf() const {
    if (!settings_.signals.empty()) return settings_.signals;
    std::vector<configuration::SignalSettings> by_name;
    for (const can::Signal& signal : found_.message->signals) {
      if (signal.multiplexing == can::Multiplexing::kSelector || IsProtection(signal.name)) continue;
      const simulation::Quantity* const quantity = simulation::FindQuantity(signal.name);
      if (quantity == nullptr) {
        throw base::UsageError(
            place_ + At(signal.line) + found_.message->name + "." + signal.name +
            " is no quantity of the emulator: say with `signals` what it carries, or name it one of " +
            AllSignals());
      }
      configuration::SignalSettings settings;
      settings.signal = signal.name;
      settings.quantity = quantity->name;
      by_name.push_back(settings);
    }
    return by_name;
  }

  bool IsProtection(const std::string& signal) const {
    return signal == settings_.protection.counter || signal == settings_.protection.checksum;
  }

  void Bind(const configuration::SignalSettings& settings) {
    const std::string place = settings.place.empty() ? place_ : settings.place + ": ";
    if (IsProtection(settings.signal))
      throw base::UsageError(place + found_.message->name + "." + settings.signal + " is written by e2e");
    const FoundSignal found = FindSignal(found_, settings.signal, place);
    if (found.signal->multiplexing == can::Multiplexing::kSelector)
      throw base::UsageError(place + found.Place() + found.Name() +
                             " is the multiplexer: it is sent with each of its values in turn");
    if (settings.quantity.empty()) {
      CheckConstant(found, settings, place);
      bound_.push_back({found.signal, std::nullopt, settings.constant, settings.raw});
      return;
    }
    const simulation::Quantity* const quantity = simulation::FindQuantity(settings.quantity);
    if (quantity == nullptr) FailQuantity(settings.quantity, place + found.Name() + " = ");
    const Linear convert = settings.scale.empty()
                               ? ConversionOf(found, settings.unit, quantity->unit, true, place)
                               : LineThrough(settings.scale, place + found.Name() + ".scale: ");
    CheckStroke(found, *quantity, convert, settings, place);
    const Field field{found.signal, quantity, convert, 0, IsMeasured(*quantity)};
    bound_.push_back({found.signal, field, {}, {}});
  }

  /// In the order of the DBC file, whatever that of the configuration.
  void NumberFields() {
    std::sort(bound_.begin(), bound_.end(),
              [](const Bound& a, const Bound& b) { return a.signal < b.signal; });
    int number = 0;
    for (Bound& bound : bound_) {
      if (bound.field) bound.field->number = std::min(number++, kMaxFields - 1);
    }
  }

  static FoundSignal FindSignal(const can::Databases::Found& found, const std::string& name,
                                const std::string& place) {
    try {
      return {found.database, found.message, &found.database->RequireSignal(*found.message, name)};
    } catch (const base::UsageError& error) {
      throw base::UsageError(place + error.what());
    }
  }

  [[noreturn]] static void FailQuantity(const std::string& name, const std::string& place) {
    std::vector<std::string> names;
    for (const simulation::Quantity& quantity : simulation::Quantities()) names.emplace_back(quantity.name);
    throw base::UsageError(place + "\"" + name + "\" is no quantity of the emulator; " +
                           base::DidYouMean(name, names, "there are " + base::Listed(names)));
  }

  static void CheckConstant(const FoundSignal& found, const configuration::SignalSettings& settings,
                            const std::string& place) {
    std::array<std::uint8_t, 64> data{};
    if (settings.raw) {
      can::InsertRaw(*found.signal, *settings.raw, data);
      if (can::ExtractRaw(*found.signal, data) == *settings.raw) return;
      throw base::UsageError(place + found.Place() + found.Name() + " has " +
                             std::to_string(found.signal->length_bits) +
                             " bits and cannot hold raw = " + std::to_string(*settings.raw));
    }
    if (can::Encode(*found.signal, *settings.constant, data)) return;
    const Range range = RangeOf(*found.signal);
    throw base::UsageError(
        place + found.Place() + found.Name() +
        base::Formatted(" = %.9g: must be %.9g to %.9g", *settings.constant, range.low, range.high));
  }

  /// A position must reach the signal over the whole stroke.
  void CheckStroke(const FoundSignal& found, const simulation::Quantity& quantity, const Linear& convert,
                   const configuration::SignalSettings& settings, const std::string& place) const {
    if (settings.may_clip || std::string_view(quantity.name) != "x3_in") return;
    const double stroke_in = configuration_.model.servo.stroke_in;
    const auto [low, high] = std::minmax({convert(0.0), convert(stroke_in)});
    const Range range = RangeOf(*found.signal);
    const double step = std::fabs(found.signal->factor) / 2;  // what rounding takes
    if (low >= range.low - step && high <= range.high + step) return;
    throw base::UsageError(
        place + found.Place() + found.Name() +
        base::Formatted(" holds %.6g to %.6g %s; the stroke of 0 to %.6g in is %.6g to %.6g", range.low,
                        range.high, found.signal->unit.c_str(), stroke_in, low, high) +
        ": correct unit or scale, or set may_clip = true in `signals`");
  }

  /// Values of the multiplexer that are sent: those of the signals that carry something.
  std::vector<std::optional<std::int64_t>> PageValues() const {
    const can::Signal* const selector = found_.message->Selector();
    if (selector == nullptr) return {std::nullopt};
    std::set<std::int64_t> values;
    for (const Bound& bound : bound_) {
      if (bound.signal->multiplexing == can::Multiplexing::kSelected)
        values.insert(bound.signal->selected_by);
    }
    if (values.empty()) return {std::nullopt};
    return {values.begin(), values.end()};
  }

  Page PageOf(std::optional<std::int64_t> value) const {
    Page page;
    page.selected_by = value;
    const std::span<std::uint8_t> data(page.constants.data(),
                                       static_cast<std::size_t>(found_.message->size_bytes));
    if (found_.message->j1939) std::fill(data.begin(), data.end(), kJ1939Unused);
    const auto is_there = [&](const can::Signal& signal) {
      return signal.multiplexing != can::Multiplexing::kSelected || signal.selected_by == value;
    };
    for (const can::Signal& signal : found_.message->signals) {
      if (is_there(signal)) InsertStart(signal, data);
    }
    if (value) can::InsertRaw(*found_.message->Selector(), *value, data);
    for (const Bound& bound : bound_) {
      if (!is_there(*bound.signal)) continue;
      if (bound.field) page.fields.push_back(*bound.field);
      if (bound.raw) can::InsertRaw(*bound.signal, *bound.raw, data);
      if (bound.constant) can::Encode(*bound.signal, *bound.constant, data);
    }
    return page;
  }

  const configuration::Configuration& configuration_;
  const configuration::MessageSettings& settings_;
  std::string place_;
  can::Databases::Found found_;
  std::vector<Bound> bound_;
};

}  // namespace

std::vector<PublishedMessage> BindPublished(const can::Databases& databases,
                                            const configuration::Configuration& configuration) {
  std::vector<PublishedMessage> published;
  for (const configuration::MessageSettings& settings : MessagesOf(configuration)) {
    if (published.size() == simulation::kMaxMessages)
      throw base::UsageError(settings.place + ": more than " + std::to_string(simulation::kMaxMessages) +
                             " messages in [[can.publish]]");
    published.push_back(MessageBinder(databases, configuration, settings).Bind());
  }
  return published;
}

}  // namespace servohil::signal_map
