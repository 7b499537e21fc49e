#include "signal_map/binding.hpp"

#include <algorithm>
#include <string>

#include "base/error.hpp"
#include "base/formatted.hpp"
#include "model/steady_state.hpp"
#include "signal_map/names.hpp"

namespace servohil::signal_map {
namespace {

/// "config/servohil.toml:120: can.command.p1 = GOV_OUT.P1: "
std::string Place(const configuration::Configuration& configuration, const std::string& key,
                  const std::string& value) {
  if (!configuration.places.contains(key))
    return key + " is not set, and \"" + value + "\" in its place will not do: ";
  return configuration.PlaceOf(key) + ": " + key + " = \"" + value + "\": ";
}

/// The P1 at which the piston rests closed, and fully open. Nothing: the model has no such rest.
std::optional<Range> StrokeRange(const configuration::Configuration& configuration) {
  const model::Derived derived(configuration.model);
  const model::SteadyState closed = model::SteadyStateAt(derived, 0.0);
  const model::SteadyState open = model::SteadyStateAt(derived, configuration.model.servo.stroke_in);
  if (!closed || !open) return std::nullopt;
  return Range{closed.p1_psi, open.p1_psi};
}

void CheckP1Range(const FoundSignal& found, const Linear& to_psi,
                  const configuration::Configuration& configuration, const std::string& place) {
  const std::optional<Range> needed = StrokeRange(configuration);
  if (configuration.can.command.may_clip || !needed) return;
  const Range signal = RangeOf(*found.signal);
  const auto [low, high] = std::minmax({to_psi(signal.low), to_psi(signal.high)});
  if (low <= needed->low && high >= needed->high) return;
  throw base::UsageError(
      place + found.Place() + found.Name() +
      base::Formatted(" reaches from %.6g to %.6g psi; the stroke needs %.6g to %.6g psi", low, high,
                      needed->low, needed->high) +
      ": correct unit, or scale = [[value, psi], [value, psi]], or set can.command.may_clip = true");
}

class CommandBinder {
 public:
  CommandBinder(const can::Databases& databases, const configuration::Configuration& configuration)
      : databases_(databases), configuration_(configuration), settings_(configuration.can.command) {}

  std::vector<ReceivedMessage> Bind() {
    BindP1();
    if (!settings_.enable.empty()) Bind("can.command.enable", settings_.enable, &ReceivedMessage::enable);
    if (!settings_.trip.empty()) Bind("can.command.trip", settings_.trip, &ReceivedMessage::trip);
    return std::move(incoming_);
  }

 private:
  void BindP1() {
    const std::string place = Place(configuration_, "can.command.p1", settings_.p1);
    const Reference reference = ParseReference(settings_.p1, place);
    if (!reference.value.empty()) throw base::UsageError(place + "P1 is a number: it has no value");
    const FoundSignal found = FindSignal(databases_, reference, place);
    ReceivedMessage& incoming = MessageOf(found, place);
    incoming.p1 = found.signal;
    if (!settings_.scale.empty() && !settings_.unit.empty())
      throw base::UsageError(place + "give can.command.unit or can.command.scale, not both");
    incoming.p1_to_psi = settings_.scale.empty()
                             ? ConversionOf(found, settings_.unit, "psi", false, place)
                             : LineThrough(settings_.scale, configuration_.PlaceOf("can.command.scale") +
                                                                ": can.command.scale: ");
    CheckP1Range(found, incoming.p1_to_psi, configuration_, place);
    incoming.protection = BindProtection(
        *found.database, *found.message, settings_.protection,
        [&](const std::string& key) { return configuration_.PlaceOf("can.command." + key) + ": "; });
  }

  void Bind(const char* key, const std::string& text, std::optional<Condition> ReceivedMessage::*member) {
    const std::string place = Place(configuration_, key, text);
    const Reference reference = ParseReference(text, place);
    const FoundSignal found = FindSignal(databases_, reference, place);
    Condition condition{found.signal, {}};
    if (!reference.value.empty()) condition.values = RawValuesOf(found, reference.value, place);
    MessageOf(found, place).*member = condition;
  }

  /// The message's place in the list: one that is there already, or a new one.
  ReceivedMessage& MessageOf(const FoundSignal& found, const std::string& place) {
    const auto known = std::find_if(incoming_.begin(), incoming_.end(),
                                    [&](const ReceivedMessage& one) { return one.message == found.message; });
    if (known != incoming_.end()) return *known;
    ReceivedMessage incoming;
    incoming.database = found.database;
    incoming.message = found.message;
    incoming.place = place;
    incoming.pattern = {found.message->id, found.message->extended, settings_.pgn};
    if (settings_.pgn && !found.message->extended)
      throw base::UsageError(place + found.database->file + ":" + std::to_string(found.message->line) +
                             ": message '" + found.message->name +
                             "' has an 11-bit identifier, can.command.pgn = true is for J1939's 29-bit ones");
    if (settings_.pgn) CheckGroup(incoming, found.signal->name, place);
    SetCycle(incoming);
    incoming_.push_back(incoming);
    return incoming_.back();
  }

  /// The key is for the message with P1, which comes first.
  void SetCycle(ReceivedMessage& incoming) const {
    const can::Message& message = *incoming.message;
    if (incoming_.empty() && settings_.cycle_ms > 0) {
      incoming.cycle_ms = settings_.cycle_ms;
      incoming.cycle_from = "can.command.cycle_ms";
    } else if (message.cycle_ms > 0) {
      incoming.cycle_ms = message.cycle_ms;
      incoming.cycle_from =
          incoming.database->file + ":" + std::to_string(message.line) + ", GenMsgCycleTime";
    } else {
      incoming.cycle_ms = incoming_.empty() ? configuration::kDefaultCycleMs : incoming_.front().cycle_ms;
      incoming.cycle_from = "the default";
    }
  }

  /// Another message of the files in this group would be read as this one: right for the same of another
  /// source, which has the signal, too.
  void CheckGroup(const ReceivedMessage& incoming, const std::string& signal,
                  const std::string& place) const {
    for (const can::Database& file : databases_.files) {
      for (const can::Message& other : file.messages) {
        if (!incoming.pattern.Matches(other.id, other.extended) || other.FindSignal(signal) != nullptr)
          continue;
        throw base::UsageError(place + file.file + ":" + std::to_string(other.line) + ": message '" +
                               other.name + "' has the parameter group of '" + incoming.message->name +
                               "', can.command.pgn = true would read it as that one");
      }
    }
  }

  const can::Databases& databases_;
  const configuration::Configuration& configuration_;
  const configuration::CommandSettings& settings_;
  std::vector<ReceivedMessage> incoming_;
};

struct Identified {
  std::string place;
  const can::Database* database;
  const can::Message* message;
  can::IdPattern pattern;
};

}  // namespace

std::vector<ReceivedMessage> BindCommand(const can::Databases& databases,
                                         const configuration::Configuration& configuration) {
  return CommandBinder(databases, configuration).Bind();
}

std::optional<can::E2eLayout> BindProtection(const can::Database& database, const can::Message& message,
                                             const configuration::ProtectionSettings& settings,
                                             const PlaceOfKey& place_of) {
  if (settings.profile == can::E2eProfile::kNone) return std::nullopt;
  const auto signal = [&](const char* key, const std::string& name) -> const can::Signal* {
    if (name.empty()) return nullptr;
    try {
      return &database.RequireSignal(message, name);
    } catch (const base::UsageError& error) {
      throw base::UsageError(place_of(key) + key + " = \"" + name + "\": " + error.what());
    }
  };
  const can::E2eSettings bound{settings.profile, settings.data_id, settings.data_id_mode,
                               signal("counter", settings.counter), signal("checksum", settings.checksum)};
  try {
    return can::MakeE2eLayout(bound, message);
  } catch (const base::UsageError& error) {
    throw base::UsageError(place_of("e2e") + error.what());
  }
}

void CheckIdentifiers(std::span<const ReceivedMessage> incoming, std::span<const PublishedMessage> outgoing) {
  std::vector<Identified> all;
  for (const ReceivedMessage& one : incoming)
    all.push_back({one.place, one.database, one.message, one.pattern});
  for (const PublishedMessage& one : outgoing)
    all.push_back({one.place, one.database, one.message, {one.message->id, one.message->extended, false}});
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!can::Overlap(all[i].pattern, all[j].pattern)) continue;
      const auto named = [](const Identified& one) {
        return one.message->name + " (" + one.database->file + ":" + std::to_string(one.message->line) + ")";
      };
      const bool twice = all[i].message == all[j].message;
      throw base::UsageError(all[i].place + named(all[i]) +
                             (twice ? " is named twice in the configuration: both received and published, "
                                      "or published twice"
                                    : " has the identifier of " + named(all[j])));
    }
  }
}

}  // namespace servohil::signal_map
