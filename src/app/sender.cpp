#include "servohil/app/sender.hpp"

#include <linux/can.h>
#include <linux/can/error.h>

#include <algorithm>
#include <cmath>

#include "servohil/app/ticks.hpp"
#include "servohil/rt/clock.hpp"

namespace servohil::app {
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

void Sender::TakePublication(const Publication& publication) noexcept {
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (!Has(publication.telemetry.due, i)) continue;
    Waiting& waiting = waiting_[i];
    const std::int64_t before_ns = waiting.publication.telemetry.status.recent_lateness_ns;
    const bool supersedes = waiting.due;
    waiting.due = true;
    waiting.publication = publication;
    if (!supersedes) continue;
    ++counters_.superseded;
    // Lateness since it was told before: the newer one tells that of the one it takes the place of, too.
    std::int64_t& lateness_ns = waiting.publication.telemetry.status.recent_lateness_ns;
    if (Has(tell_lateness_, i)) lateness_ns = std::max(lateness_ns, before_ns);
  }
}

void Sender::SendWaiting(bool at_once) noexcept {
  Publication publication;
  while (task_.TryPopPublication(publication)) TakePublication(publication);
  const std::int64_t now_ns = rt::MonotonicNs();
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (!waiting_[i].due || (now_ns < waiting_[i].not_before_ns && !at_once)) continue;
    waiting_[i].due = false;
    waiting_[i].not_before_ns = now_ns + static_cast<std::int64_t>(contract_.CycleTicks(i)) * kTickNs / 2;
    Send(i, waiting_[i].publication);
  }
  FollowFaults();
}

void Sender::SendAll(const std::atomic<bool>& stop) noexcept {
  patient_until_ = &stop;
  for (std::size_t i = 0; i < waiting_.size(); ++i) Send(i, task_.PublicationNow(i));
  FollowFaults();
}

void Sender::SendStopped() noexcept {
  patient_until_ = nullptr;
  Publication last = task_.PublicationNow(kMostMessages);
  last.telemetry.status.mode = Mode::kStopped;
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (Has(tell_mode_, i)) Send(i, last);
  }
}

void Sender::Send(std::size_t message, const Publication& publication) noexcept {
  const fault::Transmission& fate = publication.fate;
  if (fate.lost || publication.telemetry.status.line_down) {
    ++counters_.faulted;
    return;
  }
  const Telemetry& telemetry = publication.telemetry;
  Outgoing outgoing{contract_.Encode(message, telemetry, publication.measured), message,
                    telemetry.sample.tick, telemetry.status.command_arrival_ns};
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
  if (!line.down) SendNonsense(line, tick - followed_tick_);
  followed_tick_ = tick;
}

/// As many as have become due in `ticks`.
void Sender::SendNonsense(const fault::Line& line, std::uint64_t ticks) noexcept {
  constexpr double kMostAtOnce = 1'000.0;
  const auto due = [&](double& owed, double rate_hz) noexcept {
    owed = rate_hz == 0.0 ? 0.0 : std::min(kMostAtOnce, owed + rate_hz * SecondsOf(ticks));
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
    rt::SleepUntil(rt::MonotonicNs() + kRetryNs);
    result = network_.Send(frame);
  }
  return result;
}

void Sender::Account(const Outgoing& outgoing, can::SendResult result) noexcept {
  if (result != can::SendResult::kSent) {
    ++counters_.not_sent;
    return;
  }
  ++counters_.published;
  if (recorder_ != nullptr) recorder_->RecordSent(outgoing.tick, outgoing.message, outgoing.frame);
  if (!Has(reflect_command_, outgoing.message) || outgoing.arrival_ns <= last_arrival_ns_) return;
  last_arrival_ns_ = outgoing.arrival_ns;
  arrival_to_frame_.Record(rt::MonotonicNs() - outgoing.arrival_ns);
}

}  // namespace servohil::app
