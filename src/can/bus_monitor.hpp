#pragma once
/// What is wrong with a bus, from what is seen of it now and then: states and faults by name, and when to
/// restart a controller. No clock, no system call: whoever looks says when.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "can/bus.hpp"
#include "can/bus_condition.hpp"
#include "can/error_frame.hpp"
#include "can/socketcan/link.hpp"

namespace servohil::can {

/// The condition of one bus, by its name.
struct BusReport {
  std::string name;
  BusCondition condition;
};

/// One bus at one time.
struct BusObservation {
  std::int64_t now_ns = 0;  ///< on a clock that only goes forward
  bool gone = false;
  bool down = false;
  std::optional<Link> link;  ///< where the kernel tells; need not be there each time
  ErrorTotals errors;
  BusStatistics statistics;
  std::uint64_t conflicts = 0;
};

struct BusMonitorSettings {
  std::uint32_t bit_rate_bit_s = 500'000;
  /// After bus-off, where the kernel does not restart: this long until the first restart, then twice as long
  /// each time, up to the most; from the start again once it has held that long.
  std::int64_t backoff_ns = 100'000'000;
  std::int64_t most_backoff_ns = 10'000'000'000;
};

class BusMonitor {
 public:
  BusMonitor(std::string name, const BusMonitorSettings& settings);

  struct Notice {
    bool bad;  ///< else: good news
    std::string text;
  };
  /// @return what has changed since the last look, one line each
  std::vector<Notice> Look(const BusObservation& seen);
  const BusCondition& Condition() const noexcept { return condition_; }

  /// Once for each restart that is due: the controller is to be restarted now.
  bool TakeRestart() noexcept;

 private:
  struct Episode {
    bool active = false;
    std::int64_t last_ns = 0;        ///< last seen
    std::uint64_t count = 0;         ///< total when last looked at
    std::uint64_t count_before = 0;  ///< total when it began
  };

  void TakeController(const BusObservation& seen, std::vector<Notice>& remarks);
  void LookAtState(const BusObservation& seen, std::vector<Notice>& remarks);
  void LookAtTraffic(const BusObservation& seen);
  void LookAtFault(BusFault fault, bool seen_now, std::uint64_t total, const BusObservation& seen,
                   std::vector<Notice>& remarks);
  void LookAtFaults(const BusObservation& seen, std::vector<Notice>& remarks);
  void PlanRestart(const BusObservation& seen, bool enters_bus_off, std::vector<Notice>& remarks);
  std::string Explain(BusFault fault, const BusObservation& seen, std::uint64_t total) const;

  std::string name_;
  BusMonitorSettings settings_;
  BusCondition condition_;
  std::array<Episode, kBusFaultCount> episodes_{};
  Controller controller_;  ///< as told last
  bool answers_ = true;    ///< what is told can be true
  std::int64_t state_since_ns_ = 0;
  std::uint64_t entered_bus_off_ = 0;
  std::uint64_t not_sent_before_ = 0;  ///< when the state left error-active
  // Traffic: has anything good passed since disturbances began?
  std::uint64_t disturbed_frames_ = 0;  ///< since the last good frame
  std::int64_t last_disturbed_ns_ = 0;
  std::int64_t last_good_ns_ = 0;
  BusObservation before_;
  // Restart.
  std::int64_t backoff_ns_;
  std::int64_t restart_at_ns_ = kNever;
  std::int64_t last_restart_ns_ = kNever;
  static constexpr std::int64_t kNever = INT64_MAX;
};

}  // namespace servohil::can
