#include "servohil/app/contract.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "servohil/can/codec.hpp"
#include "servohil/error.hpp"

namespace servohil::app {
namespace {

constexpr const char* kCommandMessage = "GOV_Command";
constexpr const char* kCommandSignal = "P1_Demand";
constexpr int kTicksPerMs = 10;
constexpr int kClassicalBytes = 8;

/// One emulator quantity that a signal may carry.
struct Quantity {
  const char* signal;
  const char* unit;
  double (*value)(const Telemetry&);
};

double Ms(std::int64_t ns) {
  return static_cast<double>(ns) / 1e6;
}

using T = Telemetry;

constexpr std::array kPositionQuantities = std::to_array<Quantity>({
    {"X3", "in", [](const T& t) { return t.sample.state.x3_in; }},
    {"V3", "in/s", [](const T& t) { return t.sample.state.v3_in_s; }},
    {"Tick", "", [](const T& t) { return static_cast<double>(t.sample.tick & 0xFFFF'FFFFU); }},
});
constexpr std::array kPressureQuantities = std::to_array<Quantity>({
    {"P1_Applied", "psi", [](const T& t) { return t.sample.p1_psi; }},
    {"P3", "psi", [](const T& t) { return t.sample.state.p3_psi; }},
    {"P4", "psi", [](const T& t) { return t.sample.state.p4_psi; }},
    {"P8", "psi", [](const T& t) { return t.sample.state.p8_psi; }},
});
constexpr std::array kRelayQuantities = std::to_array<Quantity>({
    {"X1", "in", [](const T& t) { return t.outputs.x1_in; }},
    {"X2", "in", [](const T& t) { return t.outputs.x2_in; }},
    {"X4", "in", [](const T& t) { return t.outputs.x4_in; }},
    {"SubSteps", "", [](const T& t) { return static_cast<double>(t.sample.sub_steps); }},
});
constexpr std::array kStatusQuantities = std::to_array<Quantity>({
    {"Mode", "", [](const T& t) { return static_cast<double>(t.status.mode); }},
    {"TimingValid", "", [](const T& t) { return t.status.TimingValid() ? 1.0 : 0.0; }},
    {"ModelFault", "", [](const T& t) { return t.sample.model_fault ? 1.0 : 0.0; }},
    {"Stuck", "", [](const T& t) { return t.sample.state.mode.PistonRests() ? 1.0 : 0.0; }},
    {"ActiveFaults", "", [](const T& t) { return static_cast<double>(t.status.active_faults); }},
    {"Unresolved", "", [](const T& t) { return t.sample.unresolved_ticks > 0 ? 1.0 : 0.0; }},
    {"LateTicks", "", [](const T& t) { return static_cast<double>(t.status.late.Total()); }},
    {"WorstLateness", "ms", [](const T& t) { return Ms(t.status.worst_lateness_ns); }},
    {"RecentLateness", "ms", [](const T& t) { return Ms(t.status.recent_lateness_ns); }},
    {"CommandAge", "ms",
     [](const T& t) {
       return t.status.commanded ? static_cast<double>(t.status.command_age_ticks) / kTicksPerMs
                                 : std::numeric_limits<double>::infinity();
     }},
});

struct MessageSpecification {
  const char* name;
  std::span<const Quantity> quantities;
  int PublishSettings::*cycle_ms;
};

/// In the order of enum Published.
const std::array<MessageSpecification, kPublishedCount> kSpecifications = {{
    {"SERVO_Position", kPositionQuantities, &PublishSettings::position_ms},
    {"SERVO_Pressures", kPressureQuantities, &PublishSettings::pressures_ms},
    {"SERVO_Relay", kRelayQuantities, &PublishSettings::relay_ms},
    {"SERVO_Status", kStatusQuantities, &PublishSettings::status_ms},
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
  for (std::size_t i = 0; i < kPublishedCount; ++i) {
    const MessageSpecification& specification = kSpecifications[i];
    Outgoing& outgoing = outgoing_[i];
    outgoing.cycle_ms = publish.*specification.cycle_ms;
    if (outgoing.cycle_ms == 0) continue;
    outgoing.message = &database_.RequireMessage(specification.name);
    CheckSize(database_, *outgoing.message);
    for (const can::Signal& signal : outgoing.message->signals) {
      const auto quantity = std::find_if(specification.quantities.begin(), specification.quantities.end(),
                                         [&](const Quantity& q) { return signal.name == q.signal; });
      if (quantity == specification.quantities.end()) {
        std::string known;
        for (const Quantity& q : specification.quantities)
          known += (known.empty() ? "" : ", ") + std::string(q.signal);
        throw UsageError(At(database_, signal.line) + outgoing.message->name + "." + signal.name +
                         " is no quantity of the emulator; this message may carry " + known);
      }
      CheckUnit(database_, *outgoing.message, signal, quantity->unit);
      outgoing.fields.push_back({&signal, quantity->value});
    }
  }
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
  return Command{p1_psi};
}

can::Frame Contract::Encode(Published which, const Telemetry& telemetry) const noexcept {
  const Outgoing& outgoing = outgoing_[static_cast<std::size_t>(which)];
  can::Frame frame;
  frame.id = outgoing.message->id;
  frame.extended = outgoing.message->extended;
  frame.size = static_cast<std::uint8_t>(outgoing.message->size_bytes);
  const std::span<std::uint8_t> data(frame.data.data(), frame.size);
  for (const Field& field : outgoing.fields) can::Encode(*field.signal, field.value(telemetry), data);
  return frame;
}

std::uint64_t Contract::CycleTicks(Published which) const noexcept {
  return static_cast<std::uint64_t>(outgoing_[static_cast<std::size_t>(which)].cycle_ms) * kTicksPerMs;
}

}  // namespace servohil::app
