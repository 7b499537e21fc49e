#include <algorithm>

#include "can/e2e/e2e.hpp"

namespace servohil::can {

E2eVerdict E2eChecker::Check(std::uint32_t frame_id, std::span<const std::uint8_t> data) noexcept {
  if (!IsIntact(layout_, frame_id, data)) return Reject();
  return Follow(CounterOf(layout_, data));
}

E2eVerdict E2eChecker::Reject() noexcept {
  ++counters_.corrupted;
  return E2eVerdict::kCorrupted;
}

E2eVerdict E2eChecker::Follow(unsigned counter) noexcept {
  const unsigned round = layout_.modulus;
  const unsigned step = newest_ ? (counter + round - *newest_) % round : 1;
  if (step == 0) return Repeated();
  repetitions_ = 0;
  const bool valid = step <= max_jump_;
  if (!valid && round - step <= std::min(kLateWindow, (round - 1) / 2)) {
    ++counters_.reordered;
    return E2eVerdict::kReordered;
  }
  newest_ = counter;
  counters_.lost_frames += step - 1;
  if (!valid) {
    ++counters_.too_many;
    return E2eVerdict::kTooMany;
  }
  ++(step == 1 ? counters_.ok : counters_.some_lost);
  return step == 1 ? E2eVerdict::kOk : E2eVerdict::kSomeLost;
}

E2eVerdict E2eChecker::Repeated() noexcept {
  if (++repetitions_ <= kRepeatedBeforeStuck) {
    ++counters_.repeated;
    return E2eVerdict::kRepeated;
  }
  ++counters_.stuck;
  return E2eVerdict::kStuck;
}

}  // namespace servohil::can
