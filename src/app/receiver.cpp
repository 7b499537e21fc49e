#include "servohil/app/receiver.hpp"

#include <algorithm>

#include "servohil/app/ticks.hpp"
#include "servohil/rt/clock.hpp"

namespace servohil::app {

/// A frame without a receive stamp is as young as it is read.
FrameTime Receiver::TimeOf(const can::Frame& frame) const noexcept {
  if (clock_ == FrameClock::kSimulated) return {static_cast<std::int64_t>(task_.Clock()) * kTickNs, 0};
  const std::int64_t age_ns =
      frame.receive_time_ns == 0 ? 0 : std::max<std::int64_t>(0, rt::RealTimeNs() - frame.receive_time_ns);
  return {rt::MonotonicNs() - age_ns, age_ns};
}

bool Receiver::Take(const can::Frame& frame) noexcept {
  task_.TakeFaultsOfReceiver(faults_);
  const std::uint64_t next_tick = task_.Clock() + 1;
  CommandRejection why{};
  const bool is_command =
      contract_.DecodeCommand(frame, why).has_value() || why != CommandRejection::kUnknownId;
  if (fault::LineAt(faults_, next_tick).down) {
    ++counters_.faulted;
    return is_command;
  }
  if (recorder_ != nullptr) recorder_->RecordReceived(frame, frame.bus);
  const fault::Reception fate = fault::FateOfArrived(faults_, arrivals_++, next_tick);
  if (fate.lost) {
    ++counters_.faulted;
  } else if (fate.delay_ticks == 0) {
    Evaluate(frame);
  } else if (!delayed_.Push(task_.Clock() + fate.delay_ticks, frame)) {
    ++counters_.faulted;
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
  if (faults_.WaitsForFrame(frame.id, frame.extended)) task_.PutFrame(frame.id, frame.extended);
  CommandRejection why{};
  std::optional<Command> command = contract_.DecodeCommand(frame, why);
  if (!command && why == CommandRejection::kUnknownId) {
    ++counters_.foreign;
    return;
  }
  const FrameTime time = TimeOf(frame);
  if (command && clock_ == FrameClock::kReal && frame.receive_time_ns != 0)
    command->arrival_ns = time.time_ns;
  const FrameVerdict verdict = guard_.Judge(frame, command, why, time);
  task_.PutCommand(guard_.Newest());
  ++counters_.of[static_cast<std::size_t>(verdict)];
  counters_.lost = guard_.Newest().counts.lost;
}

}  // namespace servohil::app
