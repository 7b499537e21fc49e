#include "run/frame_log.hpp"

#include <algorithm>

#include "base/clock.hpp"
#include "base/formatted.hpp"

namespace servohil::run {
namespace {

constexpr std::int64_t kFirstPauseNs = base::kNsPerS;
constexpr std::int64_t kLongestPauseNs = 600 * base::kNsPerS;

using Count = unsigned long long;  // for printf
using V = simulation::FrameVerdict;

/// What to look at while more are refused for one reason than are valid.
const char* Advice(const simulation::FrameCounts& counts) {
  const auto most = std::max_element(counts.of.begin(), counts.of.end());  // the first of equals: valid
  switch (static_cast<V>(most - counts.of.begin())) {
    case V::kMalformed:
      return "; is the message as long as the DBC says?";
    case V::kOutOfRange:
      return "; is P1 within the DBC's range and safety.p1_minimum_psi to safety.p1_maximum_psi?";
    case V::kNotAvailable:
    case V::kErrorIndicator:
      return "; the governor has no P1 to send: values that SAE J1939-71 sets aside";
    case V::kTooFast:
      return "; does safety.p1_rate_psi_s fit?";
    case V::kCorrupted:
      return "; do can.command.e2e, data_id, data_id_mode, counter and checksum fit the governor?";
    case V::kRepeated:
    case V::kStuck:
      return "; is can.command.counter the signal that counts, and does it?";
    case V::kReordered:
    case V::kJumped:
      return "; does the counter go by 1 and round where the DBC's maximum says, is "
             "can.command.max_counter_jump "
             "enough?";
    default:
      return "";
  }
}

bool HasNews(const simulation::FrameCounts& now, const simulation::FrameCounts& told) {
  return now.Rejected() > told.Rejected() || now.lost > told.lost;
}

std::string Describe(const simulation::FrameCounts& now, const simulation::FrameCounts& told) {
  std::string text;
  for (std::size_t i = 0; i < simulation::kFrameVerdicts; ++i) {
    const auto verdict = static_cast<V>(i);
    if (verdict == V::kValid || now.of[i] == told.of[i]) continue;
    std::string name = simulation::NameOf(verdict);
    std::replace(name.begin(), name.end(), '_', ' ');
    text += (text.empty() ? "command frames refused: " : ", ") +
            base::Formatted("%llu ", Count{now.of[i] - told.of[i]}) + name;
  }
  if (now.lost > told.lost)
    text += (text.empty() ? "command frames: " : "; ") +
            base::Formatted("%llu never came", Count{now.lost - told.lost});
  return text + Advice(now);
}

}  // namespace

std::string FrameLog::Look(const simulation::FrameCounts& counts, std::int64_t now_ns) {
  if (now_ns < not_before_ns_) return {};
  if (!HasNews(counts, told_)) {
    pause_ns_ = 0;
    return {};
  }
  pause_ns_ = std::clamp(2 * pause_ns_, kFirstPauseNs, kLongestPauseNs);
  not_before_ns_ = now_ns + pause_ns_;
  std::string text = Describe(counts, told_);
  told_ = counts;
  return text;
}

std::string FrameLog::Rest(const simulation::FrameCounts& counts) const {
  return HasNews(counts, told_) ? Describe(counts, told_) : std::string();
}

}  // namespace servohil::run
