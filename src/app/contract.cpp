#include "servohil/app/contract.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "servohil/can/codec.hpp"
#include "servohil/error.hpp"

namespace servohil::app {
namespace {

constexpr const char* kCommandMessage = "GOV_Command";
constexpr const char* kCommandSignal = "P1_Demand";
constexpr int kTicksPerMs = 10;
constexpr int kClassicalBytes = 8;

struct MessageSpecification {
  const char* name;
  std::span<const char* const> quantities;
  int PublishSettings::*cycle_ms;
};

constexpr std::array kPosition = {"x3_in", "v3_in_s", "tick"};
constexpr std::array kPressures = {"p1_psi", "p3_psi", "p4_psi", "p8_psi"};
constexpr std::array kRelay = {"x1_in", "x2_in", "x4_in", "sub_steps"};
constexpr std::array kStatus = {
    "mode",       "timing_valid",      "model_fault",        "stuck",         "active_faults", "unresolved",
    "late_ticks", "worst_lateness_ms", "recent_lateness_ms", "command_age_ms"};

constexpr std::array kSafety = {"safety_state",   "safety_cause",     "rejected_frames",
                                "command_losses", "corrupted_frames", "frames_out_of_sequence",
                                "lost_frames",    "stale_frames"};

const std::array<MessageSpecification, 5> kSpecifications = {{
    {"SERVO_Position", kPosition, &PublishSettings::position_ms},
    {"SERVO_Pressures", kPressures, &PublishSettings::pressures_ms},
    {"SERVO_Relay", kRelay, &PublishSettings::relay_ms},
    {"SERVO_Safety", kSafety, &PublishSettings::safety_ms},
    {"SERVO_Status", kStatus, &PublishSettings::status_ms},
}};

std::string At(const can::Database& database, int line) {
  return database.file + ":" + std::to_string(line) + ": ";
}

void CheckUnit(const can::Database& database, const can::Message& message, const can::Signal& signal,
               const std::string& unit) {
  if (signal.unit == unit) return;
  throw UsageError(At(database, signal.line) + message.name + "." + signal.name + " has the unit \"" +
                   signal.unit + "\", expected \"" + unit + "\"");
}

void CheckSize(const can::Database& database, const can::Message& message) {
  if (message.size_bytes <= kClassicalBytes) return;
  throw UsageError(At(database, message.line) + message.name + " has " + std::to_string(message.size_bytes) +
                   " bytes, expected at most 8 (classical CAN)");
}

}  // namespace

Contract::Contract(can::Database database, const PublishSettings& publish)
    : database_(std::move(database)),
      command_(&database_.RequireMessage(kCommandMessage)),
      p1_demand_(&database_.RequireSignal(*command_, kCommandSignal)) {
  CheckUnit(database_, *command_, *p1_demand_, "psi");
  for (const MessageSpecification& specification : kSpecifications) {
    const int cycle_ms = publish.*specification.cycle_ms;
    if (cycle_ms != 0)
      Publish(database_.RequireMessage(specification.name), cycle_ms, specification.quantities);
  }
}

void Contract::Publish(const can::Message& message, int cycle_ms, std::span<const char* const> quantities) {
  CheckSize(database_, message);
  Outgoing outgoing{&message, {}, cycle_ms};
  for (const can::Signal& signal : message.signals) {
    const Quantity* const quantity = FindQuantity(signal.name);
    const bool known =
        quantity != nullptr && std::any_of(quantities.begin(), quantities.end(), [&](const char* name) {
          return std::string_view(name) == quantity->name;
        });
    if (!known) {
      std::string all;
      for (const char* const name : quantities)
        all += (all.empty() ? "" : ", ") + std::string(FindQuantity(name)->signal);
      throw UsageError(At(database_, signal.line) + message.name + "." + signal.name +
                       " is no quantity of the emulator; this message may carry " + all);
    }
    CheckUnit(database_, message, signal, quantity->unit);
    outgoing.fields.push_back({&signal, quantity});
  }
  outgoing_.push_back(std::move(outgoing));
}

std::optional<Command> Contract::DecodeCommand(const can::Frame& frame,
                                               CommandRejection& rejection) const noexcept {
  if (frame.id != command_->id || frame.extended != command_->extended) {
    rejection = CommandRejection::kUnknownId;
    return std::nullopt;
  }
  if (frame.remote || int{frame.size} < command_->size_bytes) {
    rejection = CommandRejection::kMalformed;
    return std::nullopt;
  }
  const double p1_psi = can::Decode(*p1_demand_, {frame.data.data(), frame.size});
  const bool range_stated = p1_demand_->minimum < p1_demand_->maximum;
  if (!std::isfinite(p1_psi) ||
      (range_stated && (p1_psi < p1_demand_->minimum || p1_psi > p1_demand_->maximum))) {
    rejection = CommandRejection::kOutOfRange;
    return std::nullopt;
  }
  Command command;
  command.p1_psi = p1_psi;
  return command;
}

can::Frame Contract::Encode(std::size_t message, const Telemetry& telemetry,
                            const Measured& measured) const noexcept {
  const Outgoing& outgoing = outgoing_[message];
  can::Frame frame;
  frame.id = outgoing.message->id;
  frame.extended = outgoing.message->extended;
  frame.size = static_cast<std::uint8_t>(outgoing.message->size_bytes);
  const std::span<std::uint8_t> data(frame.data.data(), frame.size);
  for (const Field& field : outgoing.fields) {
    const double value = measured.Of(*field.quantity, telemetry);
    if (std::isnan(value)) {
      constexpr std::int64_t kAllOnes = -1;
      can::InsertRaw(*field.signal, kAllOnes, data);
    } else {
      can::Encode(*field.signal, value, data);
    }
  }
  return frame;
}

std::uint64_t Contract::CycleTicks(std::size_t message) const noexcept {
  return static_cast<std::uint64_t>(outgoing_[message].cycle_ms) * kTicksPerMs;
}

std::array<std::uint64_t, kMostMessages> Contract::Cycles() const noexcept {
  std::array<std::uint64_t, kMostMessages> cycles{};
  for (std::size_t i = 0; i < MessageCount(); ++i) cycles[i] = CycleTicks(i);
  return cycles;
}

MessageSet Contract::MessagesCarrying(std::string_view quantity) const noexcept {
  const Quantity* const wanted = FindQuantity(quantity);
  MessageSet set = 0;
  for (std::size_t i = 0; i < MessageCount(); ++i) {
    const auto& fields = outgoing_[i].fields;
    if (std::any_of(fields.begin(), fields.end(), [&](const Field& f) { return f.quantity == wanted; }))
      set |= SetOf(i);
  }
  return set;
}

}  // namespace servohil::app
