#include "signal_map/report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/formatted.hpp"
#include "can/dbc/codec.hpp"
#include "can/frame_bits.hpp"
#include "signal_map/names.hpp"
#include "signal_map/protection.hpp"

namespace servohil::signal_map {
namespace {

constexpr int kNameWidth = 24;
constexpr int kPlaceWidth = 34;

std::string Padded(std::string text, int width) {
  if (static_cast<int>(text.size()) < width) text.resize(static_cast<std::size_t>(width), ' ');
  return text;
}

std::string WithUnit(const std::string& number, const std::string& unit) {
  return unit.empty() ? number : number + " " + unit;
}

/// Physical value with unit; whole numbers with every digit, however many bits they have.
std::string ValueText(const can::Signal& signal, std::span<const std::uint8_t> data) {
  const std::int64_t raw = can::ExtractRaw(signal, data);
  const bool whole = signal.type == can::ValueType::kInteger && signal.factor == 1.0 && signal.offset == 0.0;
  std::string text = !whole             ? base::Formatted("%.9g", can::Decode(signal, data))
                     : signal.is_signed ? std::to_string(raw)
                                        : std::to_string(static_cast<std::uint64_t>(raw));
  text = WithUnit(text, signal.unit);
  const std::string name = can::NameOfRaw(signal, raw);
  return name.empty() ? text : text + " \"" + name + "\"";
}

std::string PlaceText(const can::Signal& signal) {
  const Range range = RangeOf(signal);
  std::string text = base::Formatted("%d|%d@%d%c", signal.start_bit, signal.length_bits,
                                     signal.little_endian ? 1 : 0, signal.is_signed ? '-' : '+');
  if (signal.type != can::ValueType::kInteger) return text + WithUnit(", float", signal.unit);
  return text + ", " + WithUnit(base::Formatted("%.6g to %.6g", range.low, range.high), signal.unit);
}

std::string LinearText(const Linear& linear) {
  std::string text;
  if (linear.factor != 1.0) text += base::Formatted(" x %.6g", linear.factor);
  if (linear.offset != 0.0)
    text += base::Formatted(" %c %.6g", linear.offset < 0.0 ? '-' : '+', std::fabs(linear.offset));
  return text;
}

/// What a double cannot hold of its raw values is said.
std::string SignalLine(const can::Signal& signal, std::string meaning) {
  const bool wide =
      signal.type == can::ValueType::kInteger && signal.length_bits > std::numeric_limits<double>::digits;
  if (wide && meaning.rfind("always ", 0) != 0) meaning += ", rounded beyond 2^53 steps";
  return "    " + Padded(signal.name, kNameWidth) + " " + Padded(PlaceText(signal), kPlaceWidth) + " " +
         meaning + "\n";
}

std::string ConditionText(const Condition& condition, const char* what) {
  if (condition.values.empty()) return std::string(what) + " unless 0";
  std::string text;
  for (const std::int64_t value : condition.values) {
    const std::string name = can::NameOfRaw(*condition.signal, value);
    text += (text.empty() ? " while " : " or ") + std::to_string(value) +
            (name.empty() ? "" : " \"" + name + "\"");
  }
  return what + text;
}

std::string MessageLine(const can::Database& database, const can::Message& message,
                        const can::IdPattern& pattern, int cycle_ms, const configuration::CanSettings& can) {
  const can::FrameBits bits = can::WorstCaseBits(message);
  const double seconds = bits.nominal / static_cast<double>(can.bit_rate_bit_s) +
                         bits.data / static_cast<double>(can.data_bit_rate_bit_s);
  std::string text = "  " + message.name + "  " + IdText(message.id, message.extended);
  if (pattern.pgn) text += base::Formatted(", PGN %u of any source", can::PgnOf(message.id));
  text +=
      base::Formatted(", %d bytes%s, every %d ms, ", message.size_bytes, message.fd ? " FD" : "", cycle_ms);
  text += bits.data == 0 ? base::Formatted("%d bits", bits.nominal)
                         : base::Formatted("%d bits and %d at the second rate", bits.nominal, bits.data);
  return text + base::Formatted(", %.1f %% of the bus; ", seconds * 1e5 / cycle_ms) + database.file + ":" +
         std::to_string(message.line) + "\n";
}

std::string DescribeIncoming(const ReceivedMessage& incoming) {
  std::string text = ProtectionLine(incoming.protection);
  for (const can::Signal& signal : incoming.message->signals) {
    if (&signal == incoming.p1) {
      const Range range = RangeOf(signal);
      text += SignalLine(signal, "P1 = value" + LinearText(incoming.p1_to_psi) +
                                     base::Formatted(": %.6g to %.6g psi", incoming.p1_to_psi(range.low),
                                                     incoming.p1_to_psi(range.high)));
    }
    if (incoming.enable && &signal == incoming.enable->signal)
      text += SignalLine(signal, ConditionText(*incoming.enable, "enabled"));
    if (incoming.trip && &signal == incoming.trip->signal)
      text += SignalLine(signal, ConditionText(*incoming.trip, "tripped"));
    if (const char* const role = RoleOf(incoming.protection, signal); role != nullptr)
      text += SignalLine(signal, std::string(role) + " of e2e");
  }
  return text;
}

std::string DescribePage(const PublishedMessage& outgoing, const Page& page) {
  std::string text;
  const std::span<const std::uint8_t> data(page.constants.data(),
                                           static_cast<std::size_t>(outgoing.message->size_bytes));
  if (page.selected_by && outgoing.pages.size() > 1)
    text += base::Formatted("   with %s = %lld:\n", outgoing.message->Selector()->name.c_str(),
                            static_cast<long long>(*page.selected_by));
  for (const can::Signal& signal : outgoing.message->signals) {
    if (!can::Carries(*outgoing.message, signal, data)) continue;
    const auto field = std::find_if(page.fields.begin(), page.fields.end(),
                                    [&](const Field& one) { return one.signal == &signal; });
    const char* const role = RoleOf(outgoing.protection, signal);
    std::string meaning =
        role == nullptr ? "always " + ValueText(signal, data) : std::string(role) + " of e2e";
    if (field != page.fields.end()) meaning = field->quantity->name + LinearText(field->convert);
    text += SignalLine(signal, meaning);
  }
  return text;
}

std::string CommandMeaning(const SignalMap& signal_map, const can::Frame& frame) {
  CommandRejection why{};
  const std::optional<Demand> demand = signal_map.Decode(frame, why);
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  if (why != CommandRejection::kMalformed && !IsIntact(signal_map.FindIncoming(frame)->protection, frame))
    return "wrong counter or checksum: not a command";
  if (why == CommandRejection::kOutOfRange) add("P1 out of range: not a command");
  if (why == CommandRejection::kNotAvailable) add("P1 not available (J1939): not a command");
  if (why == CommandRejection::kErrorIndicator) add("P1 error indicator (J1939): not a command");
  if (why == CommandRejection::kMalformed) add("too short: not a command");
  if (!demand) return text;
  if (demand->p1_psi) add(base::Formatted("P1 %.6g psi", *demand->p1_psi));
  if (demand->enabled) add(*demand->enabled ? "enabled" : "not enabled");
  if (demand->trip) add(*demand->trip ? "TRIP" : "no trip");
  return text;
}

std::string PublishedMeaning(const PublishedMessage& outgoing, const can::Frame& frame) {
  const std::span<const std::uint8_t> data(frame.data.data(), frame.size);
  std::string text = IsIntact(outgoing.protection, frame) ? "" : "wrong counter or checksum";
  for (const Page& page : outgoing.pages) {
    if (page.selected_by && can::ExtractRaw(*outgoing.message->Selector(), data) != *page.selected_by)
      continue;
    for (const Field& field : page.fields) {
      const double value = (can::Decode(*field.signal, data) - field.convert.offset) / field.convert.factor;
      text +=
          (text.empty() ? "" : ", ") + std::string(field.quantity->name) + base::Formatted(" %.6g", value);
    }
  }
  return text;
}

}  // namespace

std::string IdText(std::uint32_t id, bool extended) {
  return base::Formatted(extended ? "0x%08X" : "0x%X", id);
}

std::string DescribeSignalMap(const SignalMap& signal_map, const configuration::CanSettings& can) {
  std::string text = "received\n";
  for (const ReceivedMessage& incoming : signal_map.IncomingMessages()) {
    text += MessageLine(*incoming.database, *incoming.message, incoming.pattern, incoming.cycle_ms, can);
    text += DescribeIncoming(incoming);
  }
  text += "sent\n";
  for (const PublishedMessage& outgoing : signal_map.OutgoingMessages()) {
    text += MessageLine(*outgoing.database, *outgoing.message,
                        {outgoing.message->id, outgoing.message->extended, false}, outgoing.cycle_ms, can);
    text += ProtectionLine(outgoing.protection);
    if (outgoing.on_change) text += "    only when its bits differ from the frame before\n";
    for (const Page& page : outgoing.pages) text += DescribePage(outgoing, page);
  }
  double bits_per_s = 0.0;
  for (const SignalMap::Load& load : signal_map.BusLoad()) bits_per_s += load.bits_per_s;
  return text + base::Formatted("load     %.1f %% of %d bit/s at worst-case stuffing\n",
                                100.0 * bits_per_s / can.bit_rate_bit_s, can.bit_rate_bit_s);
}

std::string DescribeFrame(const can::Message& message, const can::Frame& frame) {
  const std::span<const std::uint8_t> data(frame.data.data(), frame.size);
  std::string text;
  for (const can::Signal& signal : message.signals) {
    if (!can::Carries(message, signal, data)) continue;
    text += (text.empty() ? "" : ", ") + signal.name + " " + ValueText(signal, data);
  }
  return text;
}

std::string DescribeMeaning(const SignalMap& signal_map, const can::Frame& frame) {
  if (signal_map.FindIncoming(frame) != nullptr) return CommandMeaning(signal_map, frame);
  for (const PublishedMessage& outgoing : signal_map.OutgoingMessages()) {
    const bool same = outgoing.message->id == frame.id && outgoing.message->extended == frame.extended;
    if (same && int{frame.size} >= outgoing.message->size_bytes) return PublishedMeaning(outgoing, frame);
  }
  return {};
}

std::string DescribeSaturation(const PublishedMessage& outgoing, FieldSet fields) {
  std::string text;
  for (const Page& page : outgoing.pages) {
    for (const Field& field : page.fields) {
      if ((fields >> static_cast<unsigned>(field.number) & 1U) == 0) continue;
      fields &= ~(FieldSet{1} << static_cast<unsigned>(field.number));
      const Range range = RangeOf(*field.signal);
      text += (text.empty() ? "" : "; ") + outgoing.message->name + "." + field.signal->name + ": " +
              field.quantity->name + " leaves " +
              WithUnit(base::Formatted("%.6g to %.6g", range.low, range.high), field.signal->unit) +
              ", the frame saturates";
    }
  }
  return text;
}

}  // namespace servohil::signal_map
