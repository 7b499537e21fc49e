#include "servohil/app/receiver.hpp"

#include "servohil/rt/clock.hpp"

namespace servohil::app {
namespace {

/// A kernel's receive stamp on the clock of the loop; 0 where there is none.
std::int64_t ArrivalNs(const can::Frame& frame) noexcept {
  if (frame.receive_time_ns == 0) return 0;
  return rt::MonotonicNs() - (rt::RealTimeNs() - frame.receive_time_ns);
}

}  // namespace

bool Receiver::Take(const can::Frame& frame) noexcept {
  if (recorder_ != nullptr) recorder_->RecordReceived(frame, frame.bus);
  if (frame.error) {
    TakeError(frame);
    return false;
  }
  if (IsOurs(frame)) {
    ++counters_.conflicting;
    ++inputs_[frame.bus].conflicts;
    return false;
  }
  return TakeCommand(frame);
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
  for (std::size_t i = 0; i < contract_.MessageCount(); ++i) {
    const can::Message& message = contract_.MessageOf(i);
    if (message.id == frame.id && message.extended == frame.extended) return true;
  }
  return false;
}

bool Receiver::TakeCommand(const can::Frame& frame) noexcept {
  CommandRejection rejection{};
  if (std::optional<Command> command = contract_.DecodeCommand(frame, rejection)) {
    command->arrival_ns = ArrivalNs(frame);
    task_.PutCommand(*command);
    ++counters_.commands;
    return true;
  }
  switch (rejection) {
    case CommandRejection::kUnknownId:
      ++counters_.foreign;
      break;
    case CommandRejection::kMalformed:
      ++counters_.malformed;
      break;
    case CommandRejection::kOutOfRange:
      ++counters_.out_of_range;
      break;
  }
  return false;
}

}  // namespace servohil::app
