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
  if (!demand || !demand->p1_psi) return false;
  command_.arrival_ns = ArrivalNs(frame);
  task_.PutCommand(command_);
  ++counters_.commands;
  return true;
}

}  // namespace servohil::app
