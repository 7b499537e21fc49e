#pragma once
/// Account of the wake-ups that began late: how many, why, and the worst ones.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace servohil::rt {

/// Why a wake-up began late: what happened since the loop was last in time.
enum class LateCause : std::uint8_t {
  kWokeLate,      ///< the kernel woke the thread a period or more after the deadline
  kComputedLong,  ///< the work of one wake-up took a period or more (preempted work, too)
  kBoth,
};
inline constexpr std::size_t kLateCauses = 3;

/// A late wake-up and what was known of it.
struct LateWake {
  std::uint64_t wake = 0;        ///< number of the wake-up, from 1
  std::int64_t lateness_ns = 0;  ///< start of its work after its deadline
  std::int64_t compute_ns = 0;   ///< longest work since the loop was last in time
  std::uint64_t behind = 0;      ///< whole periods to catch up
  LateCause cause = LateCause::kWokeLate;
  int cpu = -1;           ///< on which it ran
  bool in_grace = false;  ///< during the start-up grace: told, not counted
};

/// A late wake-up begins a period or more after its deadline. Those that follow one another without one in
/// time between them are one overrun. Real-time safe.
class LateWakes {
 public:
  /// A wake-up in time ends the overrun.
  void InTime() noexcept { overrun_ = nullptr; }

  void Record(const LateWake& late) noexcept {
    if (late.in_grace) {
      ++in_grace_;
    } else {
      ++counts_[static_cast<std::size_t>(late.cause)];
    }
    Keep(late);
  }

  std::uint64_t Count(LateCause cause) const noexcept { return counts_[static_cast<std::size_t>(cause)]; }
  std::uint64_t Count() const noexcept { return counts_[0] + counts_[1] + counts_[2]; }
  std::uint64_t CountInGrace() const noexcept { return in_grace_; }

  /// The worst wake-up of each of the worst overruns, in no particular order.
  std::span<const LateWake> Worst() const noexcept { return {worst_.data(), kept_}; }

 private:
  static constexpr std::size_t kMaxKept = 10;

  void Keep(const LateWake& late) noexcept {
    if (overrun_ == nullptr) {
      overrun_ = SlotFor(late);
    } else if (late.lateness_ns <= overrun_->lateness_ns) {
      return;
    }
    if (overrun_ != nullptr) *overrun_ = late;
  }
  /// A free slot, or that of the least late one if it is less late than this.
  LateWake* SlotFor(const LateWake& late) noexcept {
    if (kept_ < kMaxKept) return &worst_[kept_++];
    LateWake* least =
        std::min_element(worst_.begin(), worst_.end(),
                         [](const LateWake& a, const LateWake& b) { return a.lateness_ns < b.lateness_ns; });
    return least->lateness_ns < late.lateness_ns ? least : nullptr;
  }

  std::array<std::uint64_t, kLateCauses> counts_{};
  std::uint64_t in_grace_ = 0;
  std::array<LateWake, kMaxKept> worst_{};
  std::size_t kept_ = 0;
  LateWake* overrun_ = nullptr;  ///< slot of the overrun that goes on
};

}  // namespace servohil::rt
