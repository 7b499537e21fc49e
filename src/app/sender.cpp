#include "servohil/app/sender.hpp"

#include <algorithm>

#include "servohil/app/ticks.hpp"
#include "servohil/rt/clock.hpp"

namespace servohil::app {
namespace {

constexpr std::int64_t kRetryNs = 200'000;  // a full queue is asked again

}  // namespace

/// A change is told at once, with the newest state there is.
void Sender::TakeBusCondition() noexcept {
  const can::BusCondition before = bus_;
  if (!conditions_.Take(bus_) || bus_.IsLike(before)) return;
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (Has(tell_bus_, i)) waiting_[i] = {.due = true, .telemetry = newest_};
  }
}

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
    newest_ = telemetry;
  }
  TakeBusCondition();
  nothing_waits_ = true;
  const std::int64_t now_ns = rt::MonotonicNs();
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (!waiting_[i].due) continue;
    if (now_ns < waiting_[i].not_before_ns && !at_once) {
      nothing_waits_ = false;
      continue;
    }
    waiting_[i].due = false;
    waiting_[i].not_before_ns = now_ns + static_cast<std::int64_t>(contract_.CycleTicks(i)) * kTickNs / 2;
    waiting_[i].telemetry.bus = bus_;
    Send(i, waiting_[i].telemetry);
  }
}

void Sender::SendAll(Telemetry telemetry, const std::atomic<bool>& stop,
                     std::span<const std::size_t> order) noexcept {
  conditions_.Take(bus_);
  telemetry.bus = bus_;
  for (const std::size_t i : order) {
    const can::Frame frame = contract_.Encode(i, telemetry);
    can::SendResult result = network_.Send(frame);
    while (result == can::SendResult::kQueueFull && !stop.load(std::memory_order_relaxed)) {
      rt::SleepUntil(rt::MonotonicNs() + kRetryNs);
      result = network_.Send(frame);
    }
    Account(i, telemetry, frame, result);
  }
}

void Sender::SendStopped() noexcept {
  Telemetry last = task_.Now();
  last.status.mode = Mode::kStopped;
  last.bus = bus_;
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (Has(tell_mode_, i)) Send(i, last);
  }
}

void Sender::Send(std::size_t message, const Telemetry& telemetry) noexcept {
  const can::Frame frame = contract_.Encode(message, telemetry);
  Account(message, telemetry, frame, network_.Send(frame));
}

void Sender::Account(std::size_t message, const Telemetry& telemetry, const can::Frame& frame,
                     can::SendResult result) noexcept {
  if (result != can::SendResult::kSent) {
    ++counters_.not_sent;
    return;
  }
  ++counters_.published;
  if (recorder_ != nullptr) recorder_->RecordSent(telemetry.sample.tick, message, frame);
  const std::int64_t arrival_ns = telemetry.status.command_arrival_ns;
  if (!Has(reflect_command_, message) || arrival_ns <= last_arrival_ns_) return;
  last_arrival_ns_ = arrival_ns;
  arrival_to_frame_.Record(rt::MonotonicNs() - arrival_ns);
}

}  // namespace servohil::app
