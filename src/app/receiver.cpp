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
  task_.TakeFaultsOfReceiver(faults_);
  const std::uint64_t next_tick = task_.Clock() + 1;
  CommandRejection rejection{};
  const std::optional<Demand> demand = contract_.Decode(frame, rejection);
  const bool is_command = demand && demand->p1_psi;
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
  TakeCommand(frame);
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

void Receiver::TakeCommand(const can::Frame& frame) noexcept {
  CommandRejection rejection{};
  const std::optional<Demand> demand = contract_.Decode(frame, rejection);
  if (demand) Merge(*demand, command_);
  switch (rejection) {
    case CommandRejection::kNone:
      break;
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
  if (!demand || !demand->p1_psi) return;
  command_.arrival_ns = ArrivalNs(frame);
  task_.PutCommand(command_);
  ++counters_.commands;
}

}  // namespace servohil::app
