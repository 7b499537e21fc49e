#include "can/bus_monitor.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include "can/monotonic.hpp"

namespace servohil::can {
namespace {

/// A fault is over when it has not been seen for so long: it is told once, not by frame.
constexpr std::int64_t kHoldNs = kNsPerS;
/// So many destroyed frames with nothing good between them are no accident: a sender that is disturbed gives
/// up (bus-off) after 32, and tries a good bus again before that.
constexpr std::uint64_t kMismatchFrames = 20;
constexpr std::uint8_t kWarningErrors = 96;

BusState StateOf(ControllerState state) noexcept {
  return static_cast<BusState>(state);  // the same order
}

std::string Count(std::uint64_t number, const char* what) {
  return std::to_string(number) + ' ' + what + (number == 1 ? "" : "s");
}

std::string Seconds(std::int64_t ns) {
  const std::int64_t tenths = ns / (100 * kNsPerMs);
  return std::to_string(tenths / 10) + '.' + std::to_string(tenths % 10) + " s";
}

}  // namespace

const char* NameOf(BusState state) noexcept {
  static constexpr std::array kNames = {"error-active", "error-warning", "error-passive",
                                        "bus-off",      "down",          "gone"};
  return kNames[static_cast<std::size_t>(state)];
}

const char* NameOf(BusFault fault) noexcept {
  static constexpr std::array<const char*, kBusFaultCount> kNames = {
      "bit-rate mismatch", "no acknowledgement", "transmit queue full", "receive overrun", "id conflict"};
  return kNames[static_cast<std::size_t>(fault)];
}

BusCondition Worst(const BusCondition& a, const BusCondition& b) noexcept {
  BusCondition worst = a;
  worst.state = std::max(a.state, b.state);
  worst.faults = static_cast<std::uint8_t>(a.faults | b.faults);
  worst.tx_errors = std::max(a.tx_errors, b.tx_errors);
  worst.rx_errors = std::max(a.rx_errors, b.rx_errors);
  worst.error_frames += b.error_frames;
  worst.not_sent += b.not_sent;
  worst.overruns += b.overruns;
  worst.conflicts += b.conflicts;
  worst.bus_offs += b.bus_offs;
  return worst;
}

BusMonitor::BusMonitor(std::string name, const BusMonitorSettings& settings)
    : name_(std::move(name)), settings_(settings), backoff_ns_(settings.backoff_ns) {}

std::vector<BusMonitor::Notice> BusMonitor::Look(const BusObservation& seen) {
  std::vector<Notice> remarks;
  if (state_since_ns_ == 0) state_since_ns_ = seen.now_ns;
  condition_.error_frames = seen.errors.frames;
  condition_.not_sent = seen.statistics.dropped_queue_full + seen.statistics.dropped_disconnected;
  condition_.overruns = seen.statistics.receive_overflows + seen.errors.controller_overflows;
  condition_.conflicts = seen.conflicts;
  LookAtState(seen, remarks);
  LookAtTraffic(seen);
  LookAtFaults(seen, remarks);
  before_ = seen;
  return remarks;
}

/// Registers that read as all ones: nobody drives the wires. A controller with such counters is not
/// error-active.
bool Answers(const Controller& told) noexcept {
  constexpr std::uint8_t kAllOnes = 255;
  return told.state != ControllerState::kErrorActive || told.tx_errors != kAllOnes ||
         told.rx_errors != kAllOnes;
}

/// By error frames at once; by the kernel, which knows better, whenever it was asked.
void BusMonitor::TakeController(const BusObservation& seen, std::vector<Notice>& remarks) {
  if (seen.errors.frames != before_.errors.frames) {
    controller_.state = seen.errors.state;
    controller_.tx_errors = seen.errors.tx_errors;
    controller_.rx_errors = seen.errors.rx_errors;
  }
  if (!seen.link || !seen.link->controller) return;
  const Controller& told = *seen.link->controller;
  const bool answered = std::exchange(answers_, Answers(told));
  if (answered && !answers_)
    remarks.push_back({true, name_ + ": the adapter does not answer; is it plugged in firmly?"});
  if (!answered && answers_) remarks.push_back({false, name_ + ": the adapter answers again"});
  if (!answers_) return;
  // A driver that does not tell its counters: they are zero after a restart, which no error frame tells.
  const bool restarted =
      controller_.state == ControllerState::kBusOff && told.state == ControllerState::kErrorActive;
  if (told.has_counters || restarted) {
    controller_.tx_errors = told.tx_errors;
    controller_.rx_errors = told.rx_errors;
  }
  controller_.state = told.state;
  controller_.restart_ms = told.restart_ms;
}

void BusMonitor::LookAtState(const BusObservation& seen, std::vector<Notice>& remarks) {
  TakeController(seen, remarks);
  BusState state = StateOf(controller_.state);
  condition_.tx_errors = controller_.tx_errors;
  condition_.rx_errors = controller_.rx_errors;
  if (seen.down) state = BusState::kDown;
  if (seen.gone) state = BusState::kGone;
  // Told by its error frame, and by the kernel's state: whichever comes first.
  if (state == BusState::kBusOff && condition_.state != BusState::kBusOff) ++entered_bus_off_;
  const std::uint64_t bus_offs = std::max(seen.errors.bus_offs, entered_bus_off_);
  const bool enters_bus_off = bus_offs != condition_.bus_offs;
  condition_.bus_offs = bus_offs;

  if (state != condition_.state) {
    const bool bad = state != BusState::kErrorActive;
    std::string text = name_ + ": " + NameOf(state) + ", was " + NameOf(condition_.state) + " for " +
                       Seconds(seen.now_ns - state_since_ns_);
    if (seen.errors.frames != before_.errors.frames) text += ": " + seen.errors.DescribeLast();
    if (condition_.tx_errors != 0 || condition_.rx_errors != 0) {
      text += "; error counters: transmit " + std::to_string(condition_.tx_errors) + ", receive " +
              std::to_string(condition_.rx_errors);
    }
    if (!bad) text += "; " + Count(condition_.not_sent - not_sent_before_, "frame") + " not sent meanwhile";
    if (condition_.state == BusState::kErrorActive)
      not_sent_before_ = before_.statistics.dropped_queue_full + before_.statistics.dropped_disconnected;
    remarks.push_back({bad, text});
    condition_.state = state;
    state_since_ns_ = seen.now_ns;
  }
  PlanRestart(seen, enters_bus_off, remarks);
}

void BusMonitor::PlanRestart(const BusObservation& seen, bool enters_bus_off, std::vector<Notice>& remarks) {
  if (condition_.state != BusState::kBusOff) {
    restart_at_ns_ = kNever;
    return;
  }
  if (enters_bus_off) {
    if (controller_.restart_ms != 0) {
      remarks.push_back({true, name_ + ": the kernel restarts the controller within " +
                                   std::to_string(controller_.restart_ms) + " ms"});
    } else {
      const bool held = last_restart_ns_ == kNever ||
                        seen.now_ns - last_restart_ns_ > settings_.most_backoff_ns + backoff_ns_;
      if (held) backoff_ns_ = settings_.backoff_ns;
      restart_at_ns_ = seen.now_ns + backoff_ns_;
      remarks.push_back({true, name_ + ": restart in " + std::to_string(backoff_ns_ / kNsPerMs) + " ms"});
    }
  }
  // A restart that failed, or was not permitted, is tried again with the next longer wait.
  if (controller_.restart_ms == 0 && restart_at_ns_ == kNever) restart_at_ns_ = seen.now_ns + backoff_ns_;
}

bool BusMonitor::TakeRestart() noexcept {
  if (condition_.state != BusState::kBusOff || before_.now_ns < restart_at_ns_) return false;
  restart_at_ns_ = kNever;
  last_restart_ns_ = before_.now_ns;
  backoff_ns_ = std::min(2 * backoff_ns_, settings_.most_backoff_ns);
  return true;
}

void BusMonitor::LookAtTraffic(const BusObservation& seen) {
  const std::uint64_t disturbed = seen.errors.disturbances - before_.errors.disturbances;
  bool good = seen.statistics.received != before_.statistics.received;
  if (seen.link && seen.link->controller && before_.link && seen.link->index == before_.link->index) {
    // Some drivers count error frames among the received ones.
    const std::uint64_t errors = seen.errors.frames - before_.errors.frames;
    good = good || seen.link->tx_packets > before_.link->tx_packets ||
           seen.link->rx_packets > before_.link->rx_packets + errors;
  }
  if (disturbed > 0) last_disturbed_ns_ = seen.now_ns;
  if (good) last_good_ns_ = seen.now_ns;
  disturbed_frames_ = good ? 0 : disturbed_frames_ + disturbed;
}

void BusMonitor::LookAtFaults(const BusObservation& seen, std::vector<Notice>& remarks) {
  const auto total_of = [&](BusFault fault) {
    switch (fault) {
      case BusFault::kBitRateMismatch:
        return seen.errors.disturbances;
      case BusFault::kNoAcknowledge:
        return seen.errors.missing_acknowledgements;
      case BusFault::kQueueFull:
        return seen.statistics.dropped_queue_full;
      case BusFault::kReceiveOverrun:
        return condition_.overruns;
      default:
        return seen.conflicts;
    }
  };
  const bool receives_nothing_good =
      condition_.rx_errors >= kWarningErrors && seen.now_ns - last_good_ns_ > kHoldNs;
  const bool sends_to_nobody = condition_.state == BusState::kErrorPassive && condition_.tx_errors >= 128 &&
                               condition_.rx_errors == 0 && disturbed_frames_ == 0 &&
                               seen.now_ns - last_good_ns_ > kHoldNs;
  for (std::size_t i = 0; i < kBusFaultCount; ++i) {
    const auto fault = static_cast<BusFault>(i);
    const std::uint64_t total = total_of(fault);
    bool now = total != episodes_[i].count;
    if (fault == BusFault::kBitRateMismatch)
      now = (disturbed_frames_ >= kMismatchFrames && (now || condition_.state == BusState::kBusOff)) ||
            receives_nothing_good;
    if (fault == BusFault::kNoAcknowledge) now = now || sends_to_nobody;
    LookAtFault(fault, now, total, seen, remarks);
  }
}

void BusMonitor::LookAtFault(BusFault fault, bool seen_now, std::uint64_t total, const BusObservation& seen,
                             std::vector<Notice>& remarks) {
  Episode& episode = episodes_[static_cast<std::size_t>(fault)];
  const auto bit = static_cast<std::uint8_t>(1U << static_cast<unsigned>(fault));
  if (seen_now) episode.last_ns = seen.now_ns;
  if (seen_now && !episode.active) {
    episode.active = true;
    episode.count_before = fault == BusFault::kBitRateMismatch ? total - disturbed_frames_ : episode.count;
    condition_.faults = static_cast<std::uint8_t>(condition_.faults | bit);
    remarks.push_back({true, name_ + ": " + Explain(fault, seen, total - episode.count)});
  }
  const bool mended = fault == BusFault::kBitRateMismatch && disturbed_frames_ == 0 && !seen_now;
  if (episode.active && !seen_now && (mended || seen.now_ns - episode.last_ns >= kHoldNs)) {
    episode.active = false;
    condition_.faults = static_cast<std::uint8_t>(condition_.faults & ~bit);
    remarks.push_back({false, name_ + ": no more " + NameOf(fault) + "; it was " +
                                  Count(total - episode.count_before, "frame")});
  }
  episode.count = total;
}

std::string BusMonitor::Explain(BusFault fault, const BusObservation& seen, std::uint64_t count) const {
  const std::string name = NameOf(fault);
  switch (fault) {
    case BusFault::kBitRateMismatch:
      return name + "? nothing but " +
             (seen.errors.frames == 0 ? "errors"
                                      : "error frames (" + std::to_string(seen.errors.frames) + "; " +
                                            seen.errors.DescribeLast() + ')') +
             ": do all nodes run at " + std::to_string(settings_.bit_rate_bit_s) +
             " bit/s? else wires or termination";
    case BusFault::kNoAcknowledge:
      return name + ": is any other node on the bus, and running?";
    case BusFault::kQueueFull:
      return name + ": " + Count(count, "frame") +
             " not sent; is the bus overloaded, or nobody there to acknowledge?";
    case BusFault::kReceiveOverrun:
      return name + ": " + Count(count, "frame") + " lost before they could be read";
    default:
      return name + ": another node sends identifiers that are ours (" + Count(count, "frame") + ')';
  }
}

}  // namespace servohil::can
