#pragma once
/// Watches the buses of a run for the thread that watches it: faults go to the log, to the messages that tell
/// them and to whoever asks; controllers that are bus-off are restarted.

#include <cstdint>
#include <string>
#include <vector>

#include "can/bus_monitor.hpp"
#include "can/network.hpp"
#include "can/progress_watch.hpp"
#include "configuration/configuration.hpp"
#include "emulator/emulator.hpp"

namespace servohil::run {

/// As the configuration says it.
can::LinkSettings LinkSettingsOf(const configuration::CanSettings& settings);

class BusWatch {
 public:
  /// Both must outlive it.
  BusWatch(emulator::Emulator& emulator, const can::Network& network,
           const configuration::CanSettings& settings);

  /// Looks, when it is time to.
  void Look();
  const std::vector<can::BusReport>& Reports() const noexcept { return reports_; }

 private:
  struct Watched {
    const can::Bus* bus;
    std::string interface;
    can::BusMonitor monitor;
    can::ProgressWatch progress;
    can::ErrorTotals errors;
    std::int64_t linked_ns = 0;  ///< when the kernel was asked last
    int index = 0;               ///< of the interface; 0: not known
  };

  void Look(std::size_t which, std::int64_t now_ns);
  can::BusObservation Observe(std::size_t which, std::int64_t now_ns);
  void Restart(const Watched& watched);
  void Reset(const Watched& watched) const;
  void SetUpWhatIsNew(Watched& watched, const can::Link& link);

  emulator::Emulator& emulator_;
  bool configure_;
  can::LinkSettings link_;
  std::vector<Watched> watched_;
  std::vector<can::BusReport> reports_;
  std::int64_t looked_ns_ = 0;
};

/// "error-passive, transmit queue full; error counters 128/0; 12 error frames, ..." for people.
std::string Describe(const can::BusCondition& condition);

}  // namespace servohil::run
