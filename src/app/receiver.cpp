#include "servohil/app/receiver.hpp"

#include <algorithm>

#include "servohil/app/ticks.hpp"
#include "servohil/rt/clock.hpp"

namespace servohil::app {

/// A frame without a receive stamp is as young as it is read.
FrameTime Receiver::TimeOf(const can::Frame& frame) const noexcept {
  if (clock_ == FrameClock::kSimulated)
    return {static_cast<std::int64_t>(task_.Now().sample.tick) * kTickNs, 0};
  const std::int64_t age_ns =
      frame.receive_time_ns == 0 ? 0 : std::max<std::int64_t>(0, rt::RealTimeNs() - frame.receive_time_ns);
  return {rt::MonotonicNs() - age_ns, age_ns};
}

std::optional<FrameVerdict> Receiver::Take(const can::Frame& frame) noexcept {
  if (recorder_ != nullptr) recorder_->RecordReceived(frame, frame.bus);
  CommandRejection why{};
  std::optional<Command> command = contract_.DecodeCommand(frame, why);
  if (!command && why == CommandRejection::kUnknownId) {
    ++counters_.foreign;
    return std::nullopt;
  }
  const FrameTime time = TimeOf(frame);
  if (command && clock_ == FrameClock::kReal && frame.receive_time_ns != 0)
    command->arrival_ns = time.time_ns;
  const FrameVerdict verdict = guard_.Judge(frame, command, why, time);
  task_.PutCommand(guard_.Newest());
  ++counters_.of[static_cast<std::size_t>(verdict)];
  counters_.lost = guard_.Newest().counts.lost;
  return verdict;
}

}  // namespace servohil::app
