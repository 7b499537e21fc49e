#include "emulator/fault_port.hpp"

#include <algorithm>
#include <string>

#include "base/error.hpp"
#include "can/dbc/codec.hpp"
#include "model/ticks.hpp"

namespace servohil::emulator {
namespace {

constexpr double kMaxSeconds = 1e6;
constexpr double kMaxSeed = 16'777'216.0;  // a 32-bit float holds every whole number up to here

const can::Signal* Require(const can::Message& message, const char* name) {
  if (const can::Signal* signal = message.FindSignal(name)) return signal;
  throw base::UsageError("fault.allow_can = true: message " + message.name + " has no signal " + name +
                         " (config/servohil.dbc has it)");
}

/// With its default values.
fault::Injection PresetOf(const fault::Spec& spec) noexcept {
  fault::Injection injection;
  injection.id = spec.id;
  for (std::size_t i = 0; i < spec.parameters.size(); ++i) injection.values[i] = spec.parameters[i].preset;
  return injection;
}

}  // namespace

FaultPort::FaultPort(const can::Databases& databases, const Rights& rights)
    : request_(*databases.RequireMessage("FAULT_Request").message),
      response_(*databases.RequireMessage("FAULT_Response").message),
      in_{Require(request_, "Action"), Require(request_, "Number"), Require(request_, "Fault"),
          Require(request_, "Field"),  Require(request_, "Target"), Require(request_, "Value")},
      out_{Require(response_, "Action"), Require(response_, "Number"), Require(response_, "Fault"),
           Require(response_, "Result"), Require(response_, "Reason"), Require(response_, "Tick")},
      rights_(rights),
      armed_(rights.armed) {}

can::WantedId FaultPort::RequestId(const can::Databases& databases) {
  const can::Message& request = *databases.RequireMessage("FAULT_Request").message;
  return {request.id, request.extended};
}

FaultPort::Asked FaultPort::Asked::From(std::uint64_t packed) noexcept {
  return {static_cast<std::uint8_t>(packed >> 16U), static_cast<std::uint8_t>(packed >> 8U),
          static_cast<std::uint8_t>(packed)};
}

std::optional<simulation::Request> FaultPort::Take(const can::Frame& frame) noexcept {
  const bool ours = frame.id == request_.id && frame.extended == request_.extended && !frame.remote &&
                    !frame.error && frame.size >= request_.size_bytes;
  if (!ours) return std::nullopt;
  const std::span<const std::uint8_t> data(frame.data.data(), frame.size);
  const auto raw = [&](const can::Signal* signal) noexcept {
    return static_cast<std::uint8_t>(can::ExtractRaw(*signal, data));
  };
  const Asked asked{raw(in_.action), raw(in_.number), raw(in_.fault)};
  simulation::Request request;
  request.number = asked.Packed();
  const auto action = static_cast<FaultAction>(asked.action);
  if (action == FaultAction::kClearAll) {
    request.kind = simulation::Request::Kind::kClearAll;
    return request;
  }
  const fault::Spec* spec = fault::Find(asked.fault);
  if (spec == nullptr) {
    Reply(asked, FaultResult::kRejected, FaultReason::kUnknownFault);
    return std::nullopt;
  }
  const std::uint8_t target = raw(in_.target);
  switch (action) {
    case FaultAction::kSet:
      Set(asked, *spec, raw(in_.field), can::Decode(*in_.value, data));
      return std::nullopt;
    case FaultAction::kStart:
      return Start(asked, *spec, target);
    case FaultAction::kClear:
      request.kind = simulation::Request::Kind::kClear;
      request.injection.id = spec->id;
      request.injection.target = target;
      return request;
    default:
      Reply(asked, FaultResult::kRejected, FaultReason::kUnknownField);
      return std::nullopt;
  }
}

void FaultPort::Set(const Asked& asked, const fault::Spec& spec, std::uint8_t field, double value) noexcept {
  if (!set_[spec.id]) set_[spec.id] = PresetOf(spec);
  fault::Injection& injection = *set_[spec.id];
  const auto set = [&](double minimum, double maximum, const auto& assign) noexcept {
    const double within = std::clamp(value, minimum, maximum);
    const bool fits = std::fabs(value - within) <= can::RoundingOf(*in_.value, within);  // NaN does not
    if (fits) assign(within);
    Reply(asked, fits ? FaultResult::kSet : FaultResult::kRejected,
          fits ? FaultReason::kNone : FaultReason::kOutOfRange);
  };
  if (field < spec.parameters.size() && spec.parameters[field].name != nullptr) {
    const fault::ParameterSpec& p = spec.parameters[field];
    set(p.minimum, p.maximum, [&](double within) { injection.values[field] = within; });
    return;
  }
  switch (static_cast<FaultField>(field)) {
    case FaultField::kRampS:
      set(0.0, kMaxSeconds,
          [&](double within) { injection.ramp_ticks = injection.ramp_out_ticks = model::TicksOf(within); });
      return;
    case FaultField::kForS:
      set(0.0, kMaxSeconds, [&](double within) {
        injection.for_ticks = within == 0.0 ? 0 : std::max<std::uint64_t>(1, model::TicksOf(within));
      });
      return;
    case FaultField::kSeed:
      set(0.0, kMaxSeed, [&](double within) { injection.seed = static_cast<std::uint64_t>(within); });
      return;
    default:
      Reply(asked, FaultResult::kRejected, FaultReason::kUnknownField);
  }
}

/// Nothing, everything, or one of what the fault can act on.
bool FaultPort::IsTarget(const fault::Spec& spec, std::uint8_t target) const noexcept {
  if (spec.HasSignal()) return target < rights_.quantities;
  return target == fault::Injection::kEverything || (spec.HasMessage() && target < rights_.messages);
}

std::optional<simulation::Request> FaultPort::Start(const Asked& asked, const fault::Spec& spec,
                                                    std::uint8_t target) noexcept {
  simulation::Request request;
  request.number = asked.Packed();
  request.kind = simulation::Request::Kind::kInject;
  request.injection = set_[spec.id].value_or(PresetOf(spec));
  request.injection.target = target;
  if (!armed_.load(std::memory_order_relaxed)) {
    Reply(asked, FaultResult::kRejected, FaultReason::kNotArmed);
  } else if (fault::Unsupported(spec, rights_.surroundings) != nullptr) {
    Reply(asked, FaultResult::kUnsupported, FaultReason::kNotInThisRun);
  } else if (!IsTarget(spec, target)) {
    Reply(asked, FaultResult::kRejected, FaultReason::kUnknownTarget);
  } else {
    set_[spec.id].reset();
    return request;
  }
  return std::nullopt;
}

void FaultPort::TellBusy(const simulation::Request& request) noexcept {
  Reply(Asked::From(request.number), FaultResult::kRejected, FaultReason::kBusy);
}

void FaultPort::Reply(const Asked& asked, FaultResult result, FaultReason reason) noexcept {
  responses_.TryPush(Response(asked, result, reason, 0));
}

can::Frame FaultPort::ResponseTo(const simulation::Answer& answer) const noexcept {
  const Asked asked = Asked::From(answer.number);
  const auto rejected = [&](FaultReason reason) noexcept {
    return Response(asked, FaultResult::kRejected, reason, answer.tick);
  };
  switch (answer.result) {
    case simulation::Answer::Result::kApplied:
      return Response(asked, FaultResult::kApplied, FaultReason::kNone, answer.tick);
    case simulation::Answer::Result::kNoRoom:
      return rejected(FaultReason::kNoRoom);
    case simulation::Answer::Result::kNoSuchFault:
      return rejected(FaultReason::kNotInjected);
    default:
      return rejected(FaultReason::kFrozen);
  }
}

can::Frame FaultPort::Response(const Asked& asked, FaultResult result, FaultReason reason,
                               std::uint64_t tick) const noexcept {
  can::Frame frame;
  frame.id = response_.id;
  frame.extended = response_.extended;
  frame.size = static_cast<std::uint8_t>(response_.size_bytes);
  const std::span<std::uint8_t> data(frame.data.data(), frame.size);
  const auto put = [&](const can::Signal* signal, std::uint64_t raw) noexcept {
    can::InsertRaw(*signal, static_cast<std::int64_t>(raw), data);
  };
  put(out_.action, asked.action);
  put(out_.number, asked.number);
  put(out_.fault, asked.fault);
  put(out_.result, static_cast<std::uint8_t>(result));
  put(out_.reason, static_cast<std::uint8_t>(reason));
  put(out_.tick, tick);
  return frame;
}

}  // namespace servohil::emulator
