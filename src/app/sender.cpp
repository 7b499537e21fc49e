#include "servohil/app/sender.hpp"

#include <algorithm>

#include "servohil/app/ticks.hpp"
#include "servohil/rt/clock.hpp"

namespace servohil::app {
namespace {

constexpr std::int64_t kRetryNs = 200'000;  // a full queue is asked again

}  // namespace

void Sender::SendWaiting(bool at_once) noexcept {
  Telemetry telemetry;
  while (task_.TryPopTelemetry(telemetry)) {
    for (std::size_t i = 0; i < waiting_.size(); ++i) {
      if (!Has(telemetry.due, i)) continue;
      if (waiting_[i].due) {
        ++counters_.superseded;
        // Lateness since it was told before: the newer one tells that of the one it takes the place of, too.
        if (Has(tell_lateness_, i))
          telemetry.status.recent_lateness_ns =
              std::max(telemetry.status.recent_lateness_ns, waiting_[i].telemetry.status.recent_lateness_ns);
      }
      waiting_[i].due = true;
      waiting_[i].telemetry = telemetry;
    }
  }
  const std::int64_t now_ns = rt::MonotonicNs();
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (!waiting_[i].due || (now_ns < waiting_[i].not_before_ns && !at_once)) continue;
    waiting_[i].due = false;
    waiting_[i].not_before_ns = now_ns + static_cast<std::int64_t>(contract_.CycleTicks(i)) * kTickNs / 2;
    Send(i, waiting_[i].telemetry);
  }
}

void Sender::SendAll(const Telemetry& telemetry, const std::atomic<bool>& stop) noexcept {
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    const std::optional<can::Frame> frame = Next(i, telemetry);
    if (!frame) continue;
    can::SendResult result = network_.Send(*frame);
    while (result == can::SendResult::kQueueFull && !stop.load(std::memory_order_relaxed)) {
      rt::SleepUntil(rt::MonotonicNs() + kRetryNs);
      result = network_.Send(*frame);
    }
    Account(i, telemetry, *frame, result);
  }
}

void Sender::SendStopped() noexcept {
  Telemetry last = task_.Now();
  last.status.mode = Mode::kStopped;
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (Has(tell_mode_, i)) Send(i, last);
  }
}

void Sender::Send(std::size_t message, const Telemetry& telemetry) noexcept {
  if (const std::optional<can::Frame> frame = Next(message, telemetry))
    Account(message, telemetry, *frame, network_.Send(*frame));
}

std::optional<can::Frame> Sender::Next(std::size_t message, const Telemetry& telemetry) noexcept {
  const Outgoing& outgoing = contract_.OutgoingMessages()[message];
  Written& written = written_[message];
  FieldSet saturated = 0;
  const can::Frame frame = contract_.Encode(message, telemetry, written.turn++, &saturated);
  if (saturated != 0) {
    ++counters_.saturated[message];
    counters_.saturated_fields[message].fetch_or(saturated, std::memory_order_relaxed);
  }
  if (!outgoing.on_change || !written.Newest() || written.Newest()->data != frame.data) return frame;
  ++counters_.unchanged;
  return std::nullopt;
}

void Sender::Account(std::size_t message, const Telemetry& telemetry, const can::Frame& frame,
                     can::SendResult result) noexcept {
  if (result != can::SendResult::kSent) {
    ++counters_.not_sent;
    return;
  }
  ++counters_.published;
  if (contract_.OutgoingMessages()[message].on_change) written_[message].Newest() = frame;
  if (recorder_ != nullptr) recorder_->RecordSent(telemetry.sample.tick, message, frame);
  const std::int64_t arrival_ns = telemetry.status.command_arrival_ns;
  if (!Has(reflect_command_, message) || arrival_ns <= last_arrival_ns_) return;
  last_arrival_ns_ = arrival_ns;
  arrival_to_frame_.Record(rt::MonotonicNs() - arrival_ns);
}

}  // namespace servohil::app
