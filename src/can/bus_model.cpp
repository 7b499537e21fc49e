#include "can/bus_model.hpp"

#include <algorithm>

#include "can/frame_bits.hpp"
#include "can/monotonic.hpp"

namespace servohil::can {
namespace {

constexpr std::int64_t kWindowNs = 100'000'000;
/// Of the others, each with a queue of its own: 1024 frames are more than a quarter of a second at 500
/// kbit/s.
constexpr std::ptrdiff_t kMaxOfOthers = 1024;

}  // namespace

BusModel::BusModel(const BusModelSettings& settings) : settings_(settings) {
  waiting_.reserve(settings.queue_length + kMaxOfOthers);
}

std::int64_t BusModel::DurationNs(const Frame& frame) const noexcept {
  const FrameBits bits = WorstCaseBits(frame);
  return (bits.nominal + bits.data) * kNsPerS / settings_.bit_rate_bit_s;
}

bool BusModel::HasRoom(const Frame& frame, From from) noexcept {
  const auto of = [&](From whose) {
    return std::count_if(waiting_.begin(), waiting_.end(),
                         [&](const Waiting& w) { return w.passed.from == whose; });
  };
  if (from == From::kOthers) {
    if (of(From::kOthers) < kMaxOfOthers) return true;
    ++statistics_.others_dropped;
    return false;
  }
  if (std::any_of(waiting_.begin(), waiting_.end(), [&](const Waiting& w) {
        return w.passed.from == from && w.passed.frame.id == frame.id &&
               w.passed.frame.extended == frame.extended;
      }))
    ++statistics_.missed_cycles;
  if (of(From::kUs) < static_cast<std::ptrdiff_t>(settings_.queue_length)) return true;
  ++statistics_.dropped;
  return false;
}

/// Also what is dropped was asked for.
void BusModel::Account(const Frame& frame, std::int64_t now_ns) noexcept {
  if (now_ns >= window_end_ns_) {
    window_end_ns_ = now_ns + kWindowNs;
    asked_ns_ = 0;
  }
  asked_ns_ += DurationNs(frame);
  statistics_.worst_load =
      std::max(statistics_.worst_load, static_cast<double>(asked_ns_) / static_cast<double>(kWindowNs));
}

bool BusModel::Offer(const Frame& frame, From from, std::int64_t now_ns) {
  AdvanceTo(now_ns);
  Account(frame, now_ns);
  if (!HasRoom(frame, from)) return false;
  ++statistics_.frames;
  waiting_.push_back({{frame, from, now_ns, 0}, ArbitrationRank(frame)});
  return true;
}

std::int64_t BusModel::NextStart() const noexcept {
  // Offered in the order of time: the first one waits longest.
  return std::max(free_from_ns_, waiting_.front().passed.offered_ns);
}

std::vector<BusModel::Waiting>::const_iterator BusModel::WinnerAt(std::int64_t start_ns) const noexcept {
  const auto end = std::find_if(waiting_.begin(), waiting_.end(),
                                [&](const Waiting& w) { return w.passed.offered_ns > start_ns; });
  return std::min_element(waiting_.begin(), end,
                          [](const Waiting& a, const Waiting& b) { return a.rank < b.rank; });
}

void BusModel::AdvanceTo(std::int64_t now_ns) {
  for (;;) {
    if (on_the_bus_) {
      if (on_the_bus_->end_ns >= now_ns) return;
      free_from_ns_ = on_the_bus_->end_ns;
      if (on_the_bus_->from == From::kUs)
        statistics_.worst_delay_ns =
            std::max(statistics_.worst_delay_ns, on_the_bus_->end_ns - on_the_bus_->offered_ns);
      passed_.push_back(*on_the_bus_);
      on_the_bus_.reset();
    }
    if (waiting_.empty()) return;
    const std::int64_t start_ns = NextStart();
    if (start_ns >= now_ns) return;
    const auto winner = WinnerAt(start_ns);
    on_the_bus_ = winner->passed;
    on_the_bus_->end_ns = start_ns + DurationNs(winner->passed.frame);
    waiting_.erase(winner);
  }
}

std::optional<BusModel::Passed> BusModel::Next(std::int64_t until_ns) {
  AdvanceTo(until_ns + 1);
  if (passed_.empty()) return std::nullopt;
  const Passed next = passed_.front();
  passed_.pop_front();
  return next;
}

std::optional<std::int64_t> BusModel::NextEnd() const noexcept {
  if (!passed_.empty()) return passed_.front().end_ns;
  if (on_the_bus_) return on_the_bus_->end_ns;
  if (waiting_.empty()) return std::nullopt;
  const std::int64_t start_ns = NextStart();
  return start_ns + DurationNs(WinnerAt(start_ns)->passed.frame);
}

}  // namespace servohil::can
