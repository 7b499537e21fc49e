#include "emulator/sender.hpp"

#include <linux/can.h>
#include <linux/can/error.h>

#include <algorithm>
#include <cmath>

#include "base/clock.hpp"
#include "model/ticks.hpp"

namespace servohil::emulator {
namespace {

constexpr std::int64_t kRetryNs = 200'000;  // a full queue is asked again
constexpr std::uint8_t kClassicalBytes = 8;

/// A bit error in the data field (linux/can/error.h).
can::Frame BitError() noexcept {
  constexpr std::size_t kViolation = 2;
  constexpr std::size_t kPlace = 3;
  can::Frame frame;
  frame.error = true;
  frame.id = CAN_ERR_PROT;
  frame.size = kClassicalBytes;
  frame.data[kViolation] = CAN_ERR_PROT_BIT;
  frame.data[kPlace] = CAN_ERR_PROT_LOC_DATA;
  return frame;
}

}  // namespace

void Sender::TakePublication(const simulation::Publication& publication) noexcept {
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (!simulation::Has(publication.run_state.due, i)) continue;
    Waiting& waiting = waiting_[i];
    const std::int64_t before_ns = waiting.publication.run_state.status.recent_lateness_ns;
    const bool supersedes = waiting.due;
    waiting.due = true;
    waiting.publication = publication;
    if (!supersedes) continue;
    ++counters_.superseded;
    // Lateness since it was told before: the newer one tells that of the one it takes the place of, too.
    std::int64_t& lateness_ns = waiting.publication.run_state.status.recent_lateness_ns;
    if (simulation::Has(tell_lateness_, i)) lateness_ns = std::max(lateness_ns, before_ns);
  }
  newest_ = publication;
}

/// A change is told at once, with the newest state there is.
void Sender::TakeBusCondition() noexcept {
  const can::BusCondition before = bus_;
  if (!conditions_.Take(bus_) || bus_.IsLike(before)) return;
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (!simulation::Has(tell_bus_, i)) continue;
    waiting_[i].due = true;
    waiting_[i].not_before_ns = 0;
    waiting_[i].publication = newest_;
  }
}

void Sender::SendWaiting(bool at_once) noexcept {
  simulation::Publication publication;
  while (task_.TryPopPublication(publication)) TakePublication(publication);
  TakeBusCondition();
  nothing_waits_ = true;
  const std::int64_t now_ns = base::MonotonicNs();
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (!waiting_[i].due) continue;
    if (now_ns < waiting_[i].not_before_ns && !at_once) {
      nothing_waits_ = false;
      continue;
    }
    waiting_[i].due = false;
    waiting_[i].not_before_ns =
        now_ns + static_cast<std::int64_t>(signal_map_.CycleTicks(i)) * model::kTickNs / 2;
    Send(i, waiting_[i].publication);
  }
  FollowFaults();
}

void Sender::SendAll(const std::atomic<bool>& stop, std::span<const std::size_t> order) noexcept {
  patient_until_ = &stop;
  conditions_.Take(bus_);
  FollowFaults();
  for (const std::size_t i : order) {
    simulation::Publication publication = task_.PublicationNow(i);
    Send(i, publication);
  }
}

void Sender::SendStopped() noexcept {
  patient_until_ = nullptr;
  simulation::Publication last = task_.PublicationNow(simulation::kMaxMessages);
  last.run_state.status.mode = simulation::Mode::kStopped;
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (simulation::Has(tell_mode_, i)) Send(i, last);
  }
}

void Sender::Send(std::size_t message, simulation::Publication& publication) noexcept {
  publication.run_state.bus = bus_;
  const fault::Transmission& fate = publication.fate;
  // A frame that is lost on its way has had its counter: the receiver is to miss it.
  const std::optional<can::Frame> frame = Next(message, publication);
  if (!frame) return;
  if (fate.lost || publication.run_state.status.line_down) {
    ++counters_.faulted;
    return;
  }
  const simulation::RunState& run_state = publication.run_state;
  Outgoing outgoing{*frame, message, run_state.sample.tick, run_state.status.command_arrival_ns};
  fault::FlipBits({outgoing.frame.data.data(), outgoing.frame.size}, fate.flipped_bits, fate.flip_key);
  std::optional<Outgoing>& overtaken = waiting_[message].overtaken;
  if (fate.after_next && !overtaken) {
    overtaken = outgoing;
    return;
  }
  for (int copy = 0; copy < int{fate.copies}; ++copy) {
    if (fate.delay_ticks == 0) {
      Transmit(outgoing);
    } else if (!delayed_.Push(task_.Clock() + fate.delay_ticks, outgoing)) {
      ++counters_.faulted;
    }
  }
  if (!overtaken) return;
  Transmit(*overtaken);
  overtaken.reset();
}

std::optional<can::Frame> Sender::Next(std::size_t message,
                                       const simulation::Publication& publication) noexcept {
  Written& written = written_[message];
  const std::uint64_t turn = written.turn++;
  signal_map::FieldSet saturated = 0;
  const can::Frame frame =
      signal_map_.Encode(message, publication.run_state, publication.measured, turn, &saturated);
  if (saturated != 0) {
    ++counters_.saturated[message];
    counters_.saturated_fields[message].fetch_or(saturated, std::memory_order_relaxed);
  }
  std::optional<can::Frame>& newest = written.newest[turn % written.newest.size()];
  if (signal_map_.OutgoingMessages()[message].on_change && newest && newest->data == frame.data) {
    ++counters_.unchanged;
    return std::nullopt;
  }
  newest = frame;
  can::Frame protected_frame = frame;
  if (!publication.fate.counter_stuck) ++written.counter;
  signal_map_.Protect(message, written.counter, publication.fate.checksum_wrong, protected_frame);
  return protected_frame;
}

void Sender::FollowFaults() noexcept {
  task_.TakeFaultsOfSender(faults_);
  const std::uint64_t tick = task_.Clock();
  const fault::Line line = fault::LineAt(faults_, tick);
  Outgoing outgoing;
  while (delayed_.TryPop(tick, outgoing)) {
    if (line.down) {
      ++counters_.faulted;
    } else {
      Transmit(outgoing);
    }
  }
  if (!line.down) SendBabble(line, tick - followed_tick_);
  followed_tick_ = tick;
  if (!delayed_.Empty() || line.babble_hz > 0.0 || line.errors_hz > 0.0) nothing_waits_ = false;
}

/// As many as have become due in `ticks`.
void Sender::SendBabble(const fault::Line& line, std::uint64_t ticks) noexcept {
  constexpr double kMaxAtOnce = 1'000.0;
  const auto due = [&](double& owed, double rate_hz) noexcept {
    owed = rate_hz == 0.0 ? 0.0 : std::min(kMaxAtOnce, owed + rate_hz * model::SecondsOf(ticks));
    const double whole = std::floor(owed);
    owed -= whole;
    return static_cast<int>(whole);
  };
  can::Frame babble;
  babble.id = line.babble_id;
  babble.size = kClassicalBytes;
  for (int i = due(babble_owed_, line.babble_hz); i > 0; --i) {
    if (Try(babble) == can::SendResult::kSent) ++counters_.babbled;
  }
  for (int i = due(errors_owed_, line.errors_hz); i > 0; --i) {
    if (Try(BitError()) == can::SendResult::kSent) ++counters_.babbled;
  }
}

void Sender::Transmit(const Outgoing& outgoing) noexcept {
  Account(outgoing, Try(outgoing.frame));
}

can::SendResult Sender::Try(const can::Frame& frame) noexcept {
  can::SendResult result = network_.Send(frame);
  while (patient_until_ != nullptr && result == can::SendResult::kQueueFull &&
         !patient_until_->load(std::memory_order_relaxed)) {
    base::SleepUntil(base::MonotonicNs() + kRetryNs);
    result = network_.Send(frame);
  }
  return result;
}

void Sender::Account(const Outgoing& outgoing, can::SendResult result) noexcept {
  if (result != can::SendResult::kSent) {
    ++counters_.not_sent;
    for (auto& newest : written_[outgoing.message].newest) newest.reset();  // on change: once more
    return;
  }
  ++counters_.published;
  if (recorder_ != nullptr) recorder_->RecordSent(outgoing.tick, outgoing.message, outgoing.frame);
  if (!simulation::Has(reflect_command_, outgoing.message) || outgoing.arrival_ns <= last_arrival_ns_) return;
  last_arrival_ns_ = outgoing.arrival_ns;
  arrival_to_frame_.Record(base::MonotonicNs() - outgoing.arrival_ns);
}

}  // namespace servohil::emulator
