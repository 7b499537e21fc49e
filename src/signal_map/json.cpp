#include "signal_map/json.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "can/dbc/codec.hpp"
#include "can/frame_bits.hpp"
#include "signal_map/names.hpp"
#include "signal_map/protection.hpp"

namespace servohil::signal_map {
namespace {

using Json = nlohmann::json;
using Data = std::span<const std::uint8_t>;

/// Whole numbers with every digit; what is not finite becomes null.
Json ValueOf(const can::Signal& signal, Data data) {
  const bool whole = signal.type == can::ValueType::kInteger && signal.factor == 1.0 && signal.offset == 0.0;
  if (!whole) return can::Decode(signal, data);
  const std::int64_t raw = can::ExtractRaw(signal, data);
  return signal.is_signed ? Json(raw) : Json(static_cast<std::uint64_t>(raw));
}

Json SignalToJson(const can::Signal& signal) {
  const Range range = RangeOf(signal);
  return {{"signal", signal.name},         {"unit", signal.unit},
          {"start_bit", signal.start_bit}, {"length_bits", signal.length_bits},
          {"intel", signal.little_endian}, {"signed", signal.is_signed},
          {"minimum", range.low},          {"maximum", range.high}};
}

Json ProtectionToJson(const std::optional<can::E2eLayout>& protection) {
  if (!protection) return nullptr;
  Json json = {{"e2e", can::kE2eProfileNames[static_cast<std::size_t>(protection->profile)]},
               {"counter_maximum", protection->modulus - 1}};
  if (!protection->has_data_id) return json;
  json["data_id"] = protection->data_id;
  json["data_id_mode"] = can::kDataIdModeNames[static_cast<std::size_t>(protection->data_id_mode)];
  return json;
}

/// What received and sent messages have in common.
Json MessageToJson(const can::Database& database, const can::Message& message, int cycle_ms,
                   const std::optional<can::E2eLayout>& protection) {
  const can::FrameBits bits = can::WorstCaseBits(message);
  return {{"message", message.name},     {"id", message.id},     {"extended", message.extended},
          {"bytes", message.size_bytes}, {"fd", message.fd},     {"bit_rate_switch", message.bit_rate_switch},
          {"cycle_ms", cycle_ms},        {"bits", bits.nominal}, {"data_phase_bits", bits.data},
          {"file", database.file},       {"line", message.line}, {"protection", ProtectionToJson(protection)},
          {"signals", Json::array()}};
}

void AddCondition(Json& signals, const std::optional<Condition>& condition, const char* role) {
  if (!condition) return;
  Json json = SignalToJson(*condition->signal);
  json["carries"] = role;
  const auto& values = condition->values;
  json["raw"] = values.size() > 1 ? Json(values)
                : values.empty()  ? Json()
                                  : Json(values.front());  // null: any but 0
  signals.push_back(std::move(json));
}

/// Counter and checksum.
void AddProtection(Json& signals, const can::Message& message,
                   const std::optional<can::E2eLayout>& protection) {
  for (const can::Signal& signal : message.signals) {
    const char* const role = RoleOf(protection, signal);
    if (role == nullptr) continue;
    signals.push_back(SignalToJson(signal));
    signals.back()["carries"] = role;
  }
}

Json ReceivedToJson(const ReceivedMessage& incoming) {
  Json json = MessageToJson(*incoming.database, *incoming.message, incoming.cycle_ms, incoming.protection);
  json["pgn"] = incoming.pattern.pgn ? Json(can::PgnOf(incoming.message->id)) : Json();
  Json& signals = json["signals"];
  if (incoming.p1 != nullptr) {
    signals.push_back(SignalToJson(*incoming.p1));
    signals.back()["carries"] = "p1_psi";
    signals.back()["to_psi"] = {{"factor", incoming.p1_to_psi.factor}, {"offset", incoming.p1_to_psi.offset}};
  }
  AddCondition(signals, incoming.enable, "enable");
  AddCondition(signals, incoming.trip, "trip");
  AddProtection(signals, *incoming.message, incoming.protection);
  return json;
}

/// A signal of several pages stands there once for each, with the multiplexer's value.
Json SentToJson(const PublishedMessage& outgoing) {
  Json json = MessageToJson(*outgoing.database, *outgoing.message, outgoing.cycle_ms, outgoing.protection);
  json["on_change"] = outgoing.on_change;
  Json& signals = json["signals"];
  for (const Page& page : outgoing.pages) {
    for (const Field& field : page.fields) {
      Json one = SignalToJson(*field.signal);
      one["carries"] = field.quantity->name;
      one["from_quantity"] = {{"factor", field.convert.factor}, {"offset", field.convert.offset}};
      if (page.selected_by) one["multiplexer"] = *page.selected_by;
      signals.push_back(std::move(one));
    }
  }
  AddProtection(signals, *outgoing.message, outgoing.protection);
  return json;
}

void AddDemand(Json& json, const ReceivedMessage& incoming, const SignalMap& signal_map,
               const can::Frame& frame) {
  CommandRejection why{};
  const std::optional<Demand> demand = signal_map.Decode(frame, why);
  if (why == CommandRejection::kMalformed) {
    json["refused"] = "malformed";
    return;
  }
  if (!IsIntact(incoming.protection, frame)) {
    json["refused"] = "corrupted";
    return;
  }
  if (why == CommandRejection::kOutOfRange) json["refused"] = "out_of_range";
  if (why == CommandRejection::kNotAvailable) json["refused"] = "not_available";
  if (why == CommandRejection::kErrorIndicator) json["refused"] = "error_indicator";
  if (!demand) return;
  if (demand->p1_psi) json["p1_psi"] = *demand->p1_psi;
  if (demand->enabled) json["enabled"] = *demand->enabled;
  if (demand->trip) json["trip"] = *demand->trip;
}

void AddQuantities(Json& json, const PublishedMessage& outgoing, const can::Frame& frame) {
  const Data data(frame.data.data(), frame.size);
  if (!IsIntact(outgoing.protection, frame)) json["refused"] = "corrupted";
  for (const Page& page : outgoing.pages) {
    const can::Signal* const selector = outgoing.message->Selector();
    if (page.selected_by && can::ExtractRaw(*selector, data) != *page.selected_by) continue;
    for (const Field& field : page.fields) {
      const double value = (can::Decode(*field.signal, data) - field.convert.offset) / field.convert.factor;
      json["quantities"][field.signal->name] = {{"quantity", field.quantity->name}, {"value", value}};
    }
  }
}

}  // namespace

Json SignalMapToJson(const SignalMap& signal_map, const configuration::CanSettings& can) {
  Json json = {{"received", Json::array()}, {"sent", Json::array()}};
  for (const ReceivedMessage& incoming : signal_map.IncomingMessages())
    json["received"].push_back(ReceivedToJson(incoming));
  for (const PublishedMessage& outgoing : signal_map.OutgoingMessages())
    json["sent"].push_back(SentToJson(outgoing));
  double bits_per_s = 0.0;
  for (const SignalMap::Load& load : signal_map.BusLoad()) bits_per_s += load.bits_per_s;
  json["load"] = {{"share", bits_per_s / can.bit_rate_bit_s}, {"bit_rate_bit_s", can.bit_rate_bit_s}};
  return json;
}

Json FrameToJson(const can::Message& message, const SignalMap& signal_map, const can::Frame& frame) {
  Json json = {{"message", message.name}, {"id", frame.id}, {"extended", frame.extended}};
  if (frame.remote) {
    json["remote"] = true;
    return json;
  }
  const bool whole = int{frame.size} >= message.size_bytes;
  const Data data(frame.data.data(), frame.size);
  for (const can::Signal& signal : message.signals) {
    if (whole && can::Carries(message, signal, data)) json["signals"][signal.name] = ValueOf(signal, data);
  }
  if (const ReceivedMessage* const incoming = signal_map.FindIncoming(frame); incoming != nullptr) {
    AddDemand(json, *incoming, signal_map, frame);
    return json;
  }
  const auto outgoing = signal_map.OutgoingMessages();
  const auto found = std::find_if(outgoing.begin(), outgoing.end(), [&](const PublishedMessage& one) {
    return one.message->id == frame.id && one.message->extended == frame.extended;
  });
  if (!whole) {
    json["refused"] = "malformed";
  } else if (found != outgoing.end()) {
    AddQuantities(json, *found, frame);
  }
  return json;
}

}  // namespace servohil::signal_map
