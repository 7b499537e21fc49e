#include "emulator/receiver.hpp"

#include <algorithm>

#include "base/clock.hpp"
#include "model/ticks.hpp"

namespace servohil::emulator {

/// A frame without a receive stamp is as young as it is read.
FrameTime Receiver::TimeOf(const can::Frame& frame) const noexcept {
  if (clock_ == FrameClock::kSimulated)
    return {static_cast<std::int64_t>(task_.Clock()) * model::kTickNs, 0, 0};
  const std::int64_t now_ns = base::MonotonicNs();
  if (frame.receive_time_ns == 0) return {now_ns, 0, 0};
  const std::int64_t age_ns = std::max<std::int64_t>(0, base::RealTimeNs() - frame.receive_time_ns);
  return {now_ns - age_ns, age_ns, now_ns - age_ns};
}

bool Receiver::Take(const can::Frame& frame) noexcept {
  task_.TakeFaultsOfReceiver(faults_);
  const std::uint64_t next_tick = task_.Clock() + 1;
  const bool is_command = !frame.remote && signal_map_.IsCommand(frame);
  if (fault::LineAt(faults_, next_tick).down) {
    ++counters_.faulted;
    return is_command;
  }
  if (recorder_ != nullptr) recorder_->RecordReceived(frame, frame.bus);
  const fault::Reception fate = fault::FateOfArrived(faults_, arrivals_++, next_tick);
  const bool waits = !fate.lost && fate.delay_ticks != 0;
  if (fate.lost || (waits && !delayed_.Push(task_.Clock() + fate.delay_ticks, frame))) {
    ++counters_.faulted;
  } else if (!waits) {
    Evaluate(frame);
  }
  return is_command;
}

void Receiver::TakeDelayed() noexcept {
  can::Frame frame;
  while (delayed_.TryPop(task_.Clock(), frame)) {
    frame.receive_time_ns = 0;  // it has arrived now
    Evaluate(frame);
  }
}

void Receiver::Evaluate(const can::Frame& frame) noexcept {
  if (frame.error) {
    TakeError(frame);
    return;
  }
  if (IsOurs(frame)) {
    ++counters_.conflicting;
    ++inputs_[frame.bus].conflicts;
    return;
  }
  if (faults_.WaitsForFrame(frame.id, frame.extended)) task_.PutFrame(frame.id, frame.extended);
  signal_map::CommandRejection why{};
  const std::optional<signal_map::Demand> demand = signal_map_.Decode(frame, why);
  if (signal_map_.IsCommand(frame)) {
    TakeCommand(frame, demand, why);
  } else {
    TakeCondition(frame, demand, why);
  }
}

void Receiver::TakeError(const can::Frame& frame) noexcept {
  ++counters_.errors;
  Input& input = inputs_[frame.bus];
  input.errors.Take(frame);
  input.newest.Put(input.errors);
}

/// One that the emulator publishes: no other node may send it. A remote frame asks for it.
bool Receiver::IsOurs(const can::Frame& frame) const noexcept {
  if (frame.remote) return false;
  for (std::size_t i = 0; i < signal_map_.MessageCount(); ++i) {
    const can::Message& message = signal_map_.MessageOf(i);
    if (message.id == frame.id && message.extended == frame.extended) return true;
  }
  return false;
}

/// A frame of the message with P1; a multiplexed one may have other signals.
void Receiver::TakeCommand(const can::Frame& frame, const std::optional<signal_map::Demand>& demand,
                           signal_map::CommandRejection why) noexcept {
  using Why = signal_map::CommandRejection;
  const bool has_p1 = (why != Why::kNone && why != Why::kUnknownId) || (demand && demand->p1_psi);
  if (!has_p1) {
    TakeCondition(frame, demand, why);
    return;
  }
  const simulation::FrameVerdict verdict = validator_.Judge(frame, demand, why, TimeOf(frame));
  task_.PutCommand(validator_.Newest());
  ++counters_.of[static_cast<std::size_t>(verdict)];
  counters_.lost = validator_.Newest().counts.lost;
}

/// Any other frame: enable or trip, or nothing to us.
void Receiver::TakeCondition(const can::Frame& frame, const std::optional<signal_map::Demand>& demand,
                             signal_map::CommandRejection why) noexcept {
  if (demand) {
    validator_.TakeCondition(*demand, TimeOf(frame));
    task_.PutCommand(validator_.Newest());
  } else if (why == signal_map::CommandRejection::kMalformed) {
    ++counters_.of[static_cast<std::size_t>(simulation::FrameVerdict::kMalformed)];
  } else {
    ++counters_.foreign;
  }
}

}  // namespace servohil::emulator
