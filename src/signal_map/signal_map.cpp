#include "signal_map/signal_map.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "base/nearest_name.hpp"
#include "base/readable.hpp"
#include "can/dbc/codec.hpp"
#include "can/dbc/j1939.hpp"
#include "model/ticks.hpp"
#include "signal_map/binding.hpp"

namespace servohil::signal_map {
namespace {

using Data = std::span<const std::uint8_t>;

/// @param without_value  what holds where J1939 says that there is no value
std::optional<bool> Read(const std::optional<Condition>& condition, const ReceivedMessage& incoming,
                         Data data, std::optional<bool> without_value) {
  if (!condition || !can::Carries(*incoming.message, *condition->signal, data)) return std::nullopt;
  const std::int64_t raw = can::ExtractRaw(*condition->signal, data);
  const auto& values = condition->values;
  const bool named = std::find(values.begin(), values.end(), raw) != values.end();
  if (named) return true;  // an indicator, too, where the configuration names it
  if (incoming.IsJ1939() && can::J1939ValueOf(*condition->signal, raw) != can::J1939Value::kValid)
    return without_value;
  return values.empty() && raw != 0;
}

/// Reads P1 in psi into `demand`. @return why there is none
CommandRejection ReadP1(const ReceivedMessage& incoming, Data data, Demand& demand) {
  const can::Signal& signal = *incoming.p1;
  const std::int64_t raw = can::ExtractRaw(signal, data);
  if (incoming.IsJ1939()) {
    const can::J1939Value meaning = can::J1939ValueOf(signal, raw);
    if (meaning == can::J1939Value::kNotAvailable) return CommandRejection::kNotAvailable;
    if (meaning == can::J1939Value::kError) return CommandRejection::kErrorIndicator;
    if (meaning == can::J1939Value::kReserved) return CommandRejection::kOutOfRange;
  }
  const double value = can::Decode(signal, data);
  const double p1_psi = incoming.p1_to_psi(value);
  if (!can::IsInStatedRange(signal, raw) || !std::isfinite(p1_psi)) return CommandRejection::kOutOfRange;
  demand.p1_psi = p1_psi;
  const Linear& line = incoming.p1_to_psi;
  demand.p1_rounding_psi = std::fabs(line.factor) * can::RoundingOf(signal, value) +
                           (std::fabs(p1_psi) + 2.0 * std::fabs(line.offset)) * 0x1p-51;
  return CommandRejection::kNone;
}

/// What may have been meant: "; there is governor.dbc", or a few that there are.
std::string Beside(const std::filesystem::path& file) {
  std::vector<std::string> names;
  std::error_code ignored;
  const std::filesystem::path directory = file.has_parent_path() ? file.parent_path() : ".";
  for (const auto& entry : std::filesystem::directory_iterator(directory, ignored)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".dbc" || extension == ".DBC") names.push_back(entry.path().filename().string());
  }
  const std::string nearest = base::NearestName(file.filename().string(), names);
  if (!nearest.empty()) return "; there is " + nearest;
  constexpr std::size_t kMaxNamed = 6;
  std::sort(names.begin(), names.end());
  names.resize(std::min(names.size(), kMaxNamed));
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "; there is " : ", ") + name;
  return text;
}

can::Databases ReadDbcs(const configuration::Configuration& configuration) {
  for (const std::filesystem::path file : configuration.can.dbc) {
    const std::string why = base::WhyUnreadable(file);
    if (why.empty()) continue;
    throw base::UsageError(configuration.PlaceOf("can.dbc") + ": can.dbc: " + file.string() + ": " + why +
                           Beside(file));
  }
  return can::ReadDbcs(configuration.can.dbc);
}

}  // namespace

void Merge(const Demand& demand, simulation::Command& command) noexcept {
  command.p1_psi = demand.p1_psi.value_or(command.p1_psi);
  command.enabled = demand.enabled.value_or(command.enabled);
  command.trip = demand.trip.value_or(command.trip);
}

SignalMap::SignalMap(can::Databases databases, const configuration::Configuration& configuration)
    : databases_(std::move(databases)),
      incoming_(BindCommand(databases_, configuration)),
      outgoing_(BindPublished(databases_, configuration)),
      data_rate_ratio_(static_cast<double>(configuration.can.bit_rate_bit_s) /
                       configuration.can.data_bit_rate_bit_s) {
  CheckIdentifiers(incoming_, outgoing_);
  const ReceivedMessage& command = incoming_.front();
  const int stated_ms = command.message->cycle_ms;
  if (configuration.can.command.cycle_ms == 0 || stated_ms == 0 || stated_ms == command.cycle_ms) return;
  cycle_mismatch_ = configuration.PlaceOf("can.command.cycle_ms") +
                    ": can.command.cycle_ms = " + std::to_string(command.cycle_ms) + ", but " +
                    command.database->file + ":" + std::to_string(command.message->line) + ": " +
                    command.message->name + " has GenMsgCycleTime " + std::to_string(stated_ms) +
                    "; leave the key out to follow the DBC";
}

SignalMap::SignalMap(const configuration::Configuration& configuration)
    : SignalMap(ReadDbcs(configuration), configuration) {}

const ReceivedMessage* SignalMap::FindIncoming(const can::Frame& frame) const noexcept {
  const auto found = std::find_if(incoming_.begin(), incoming_.end(), [&](const ReceivedMessage& one) {
    return !frame.error && one.pattern.Matches(frame.id, frame.extended);
  });
  return found == incoming_.end() ? nullptr : &*found;
}

bool SignalMap::HasEnable() const noexcept {
  return std::any_of(incoming_.begin(), incoming_.end(),
                     [](const ReceivedMessage& one) { return one.enable.has_value(); });
}

std::vector<can::WantedId> SignalMap::Wanted() const {
  std::vector<can::WantedId> wanted;
  for (const ReceivedMessage& incoming : incoming_) wanted.push_back(incoming.pattern.Wanted());
  return wanted;
}

std::optional<Demand> SignalMap::Decode(const can::Frame& frame, CommandRejection& rejection) const noexcept {
  rejection = CommandRejection::kUnknownId;
  const ReceivedMessage* const incoming = FindIncoming(frame);
  if (incoming == nullptr) return std::nullopt;
  if (frame.remote || int{frame.size} < incoming->message->size_bytes) {
    rejection = CommandRejection::kMalformed;
    return std::nullopt;
  }
  const Data data(frame.data.data(), frame.size);
  Demand demand;
  // Without a value nothing is enabled, and nothing is tripped that was not.
  demand.enabled = Read(incoming->enable, *incoming, data, false);
  demand.trip = Read(incoming->trip, *incoming, data, std::nullopt);
  const bool has_p1 = incoming->p1 != nullptr && can::Carries(*incoming->message, *incoming->p1, data);
  if (has_p1) rejection = ReadP1(*incoming, data, demand);
  // A wrong P1 takes nothing from a trip in the same frame.
  if (!demand.p1_psi && !demand.enabled && !demand.trip) return std::nullopt;
  if (!has_p1) rejection = CommandRejection::kNone;
  return demand;
}

can::Frame SignalMap::Encode(std::size_t message, const simulation::RunState& run_state,
                             const simulation::Measured& measured, std::uint64_t turn,
                             FieldSet* saturated) const noexcept {
  const PublishedMessage& outgoing = outgoing_[message];
  const Page& page = outgoing.pages[turn % outgoing.pages.size()];
  can::Frame frame;
  frame.id = outgoing.message->id;
  frame.extended = outgoing.message->extended;
  frame.fd = outgoing.message->fd;
  frame.bit_rate_switch = outgoing.message->bit_rate_switch;
  frame.size = static_cast<std::uint8_t>(outgoing.message->size_bytes);
  frame.data = page.constants;
  const std::span<std::uint8_t> data(frame.data.data(), frame.size);
  for (const Field& field : page.fields) {
    const double value = field.convert(measured.Of(*field.quantity, run_state));
    if (std::isnan(value)) {
      constexpr std::int64_t kAllOnes = -1;
      can::InsertRaw(*field.signal, kAllOnes, data);
      continue;
    }
    const bool held = can::Encode(*field.signal, value, data) || std::isinf(value);
    if (!held && field.measured && saturated != nullptr)
      *saturated |= FieldSet{1} << static_cast<unsigned>(field.number);
  }
  return frame;
}

void SignalMap::Protect(std::size_t message, unsigned counter, bool wrong_checksum,
                        can::Frame& frame) const noexcept {
  const std::optional<can::E2eLayout>& protection = outgoing_[message].protection;
  if (!protection) return;
  const std::span<std::uint8_t> data(frame.data.data(), frame.size);
  can::Protect(*protection, frame.id, counter % protection->modulus, data);
  if (wrong_checksum) can::InvertChecksum(*protection, data);
}

bool SignalMap::AnyPublished(bool (*has)(const can::E2eLayout&)) const noexcept {
  return std::any_of(outgoing_.begin(), outgoing_.end(), [&](const PublishedMessage& message) {
    return message.protection && has(*message.protection);
  });
}

std::uint64_t SignalMap::CycleTicks(std::size_t message) const noexcept {
  return static_cast<std::uint64_t>(outgoing_[message].cycle_ms) * model::kTicksPerMs;
}

std::array<std::uint64_t, simulation::kMaxMessages> SignalMap::Cycles() const noexcept {
  std::array<std::uint64_t, simulation::kMaxMessages> cycles{};
  for (std::size_t i = 0; i < MessageCount(); ++i) cycles[i] = CycleTicks(i);
  return cycles;
}

bool SignalMap::UsesFd() const noexcept {
  const auto is_fd = [](const auto& one) { return one.message->fd; };
  return std::any_of(incoming_.begin(), incoming_.end(), is_fd) ||
         std::any_of(outgoing_.begin(), outgoing_.end(), is_fd);
}

simulation::MessageSet SignalMap::MessagesCarrying(std::string_view quantity) const noexcept {
  const simulation::Quantity* const wanted = simulation::FindQuantity(quantity);
  const auto carries = [&](const Page& page) {
    return std::any_of(page.fields.begin(), page.fields.end(),
                       [&](const Field& field) { return field.quantity == wanted; });
  };
  simulation::MessageSet set = 0;
  for (std::size_t i = 0; i < MessageCount(); ++i) {
    const auto& pages = outgoing_[i].pages;
    if (std::any_of(pages.begin(), pages.end(), carries)) set |= simulation::SetOf(i);
  }
  return set;
}

}  // namespace servohil::signal_map
