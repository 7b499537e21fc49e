#include "run/bus_watch.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "base/clock.hpp"
#include "base/error.hpp"
#include "base/formatted.hpp"
#include "can/socketcan/interface_state.hpp"

namespace servohil::run {
namespace {

constexpr std::int64_t kLookEveryNs = 100'000'000;
/// The kernel is asked for the controller's state, which may take an adapter a while.
constexpr std::int64_t kAskEveryNs = 1'000'000'000;

can::BusMonitorSettings MonitorSettingsOf(const configuration::CanSettings& settings) {
  return {.bit_rate_bit_s = static_cast<std::uint32_t>(settings.bit_rate_bit_s),
          .backoff_ns = settings.backoff_ms * base::kNsPerMs,
          .most_backoff_ns = settings.most_backoff_ms * base::kNsPerMs};
}

}  // namespace

can::LinkSettings LinkSettingsOf(const configuration::CanSettings& settings) {
  return {.bit_rate_bit_s = static_cast<std::uint32_t>(settings.bit_rate_bit_s),
          .sample_point = settings.sample_point,
          .restart_ms = static_cast<std::uint32_t>(settings.restart_ms),
          .queue_length = static_cast<std::uint32_t>(settings.queue_length)};
}

BusWatch::BusWatch(emulator::Emulator& emulator, const can::Network& network,
                   const configuration::CanSettings& settings)
    : emulator_(emulator), configure_(settings.configure), link_(LinkSettingsOf(settings)) {
  for (const auto& bus : network.Buses()) {
    Watched watched{bus.get(), bus->Interface(), {bus->Name(), MonitorSettingsOf(settings)}, {}, {}};
    // An adapter that is pulled out before the first look has to be known again, too.
    if (const auto link = can::ReadLink(watched.interface)) watched.index = link->index;
    watched_.push_back(std::move(watched));
    reports_.push_back({bus->Name(), {}});
  }
}

void BusWatch::Look() {
  const std::int64_t now_ns = base::MonotonicNs();
  if (now_ns - looked_ns_ < kLookEveryNs) return;
  looked_ns_ = now_ns;
  can::BusCondition all;
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    Look(i, now_ns);
    reports_[i].condition = watched_[i].monitor.Condition();
    all = can::Worst(all, reports_[i].condition);
  }
  emulator_.PutBusCondition(all);
}

void BusWatch::Look(std::size_t which, std::int64_t now_ns) {
  Watched& watched = watched_[which];
  const can::BusObservation seen = Observe(which, now_ns);
  for (const can::BusMonitor::Notice& remark : watched.monitor.Look(seen))
    spdlog::log(remark.bad ? spdlog::level::warn : spdlog::level::info, "{}", remark.text);
  if (watched.monitor.TakeRestart()) Restart(watched);
  if (!seen.link) return;
  if (watched.progress.IsResetDue(now_ns, watched.monitor.Condition(), seen.link->tx_packets)) Reset(watched);
  SetUpWhatIsNew(watched, *seen.link);
}

can::BusObservation BusWatch::Observe(std::size_t which, std::int64_t now_ns) {
  Watched& watched = watched_[which];
  can::BusObservation seen;
  seen.now_ns = now_ns;
  const bool news = emulator_.TakeBusErrors(which, watched.errors);
  seen.errors = watched.errors;
  seen.statistics = watched.bus->Statistics();
  seen.conflicts = emulator_.Conflicts(which);
  seen.gone = watched.bus->IsGone();
  if (watched.interface.empty()) return seen;
  seen.gone = !can::IsCanInterface(watched.interface);
  seen.down = !seen.gone && !can::IsInterfaceUp(watched.interface);
  if (!seen.gone && (news || seen.down || !watched.monitor.Condition().IsHealthy() ||
                     now_ns - watched.linked_ns >= kAskEveryNs)) {
    seen.link = can::ReadLink(watched.interface);
    watched.linked_ns = now_ns;
  }
  return seen;
}

void BusWatch::Restart(const Watched& watched) {
  switch (can::RestartLink(watched.interface)) {
    case can::RestartResult::kDone:
      spdlog::info("{}: restarted", watched.bus->Name());
      break;
    case can::RestartResult::kNotPermitted:
      spdlog::error(
          "{0}: no permission to restart it (CAP_NET_ADMIN): sudo ip link set {1} type can restart; for the "
          "kernel to "
          "do so each time: sudo ip link set {1} down; sudo ip link set {1} up type can restart-ms 100",
          watched.bus->Name(), watched.interface);
      break;
    default:
      spdlog::warn("{}: the kernel does not restart it yet", watched.bus->Name());
  }
}

void BusWatch::Reset(const Watched& watched) const {
  const char* const stuck = "frames are stuck in the controller though the bus is well";
  if (configure_ && can::ResetLink(watched.interface) == can::RestartResult::kDone) {
    spdlog::warn("{}: {}: taken down and up", watched.bus->Name(), stuck);
    return;
  }
  spdlog::error("{0}: {1}; this ends it: sudo ip link set {2} down; sudo ip link set {2} up",
                watched.bus->Name(), stuck, watched.interface);
}

/// An adapter that was pulled out and plugged in again comes back as it was made.
void BusWatch::SetUpWhatIsNew(Watched& watched, const can::Link& link) {
  const bool is_new = watched.index != 0 && link.index != watched.index;
  watched.index = link.index;
  if (!is_new || !configure_ || link.up) return;
  try {
    can::ConfigureLink(watched.interface, link_);
    spdlog::info("{}: set up anew", watched.bus->Name());
  } catch (const base::EnvironmentError& error) {
    spdlog::error("{}", error.what());
  }
}

std::string Describe(const can::BusCondition& condition) {
  std::string text = can::NameOf(condition.state);
  for (std::size_t i = 0; i < can::kBusFaultCount; ++i) {
    const auto fault = static_cast<can::BusFault>(i);
    if (condition.Has(fault)) text += std::string(", ") + can::NameOf(fault);
  }
  if (condition.tx_errors != 0 || condition.rx_errors != 0)
    text += base::Formatted("; error counters: transmit %d, receive %d", condition.tx_errors,
                            condition.rx_errors);
  return text;
}

}  // namespace servohil::run
