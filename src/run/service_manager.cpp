#include "run/service_manager.hpp"

#include <systemd/sd-daemon.h>

#include <algorithm>
#include <cstdlib>

#include "base/clock.hpp"

namespace servohil::run {
namespace {

constexpr int kKeepEnvironment = 0;

void Tell(const std::string& what) {
  sd_notify(kKeepEnvironment, what.c_str());
}

}  // namespace

ServiceManager::ServiceManager() : exists_(std::getenv("NOTIFY_SOCKET") != nullptr) {
  constexpr std::int64_t kTimesPerPeriod = 4;
  constexpr std::int64_t kNsPerUs = 1'000;
  std::uint64_t period_us = 0;
  if (sd_watchdog_enabled(kKeepEnvironment, &period_us) > 0)
    feed_every_ns_ = static_cast<std::int64_t>(period_us) * kNsPerUs / kTimesPerPeriod;
}

void ServiceManager::TellReady() const {
  Tell("READY=1");
}

void ServiceManager::TellReloading() const {
  constexpr std::int64_t kNsPerUs = 1'000;
  Tell("RELOADING=1\nMONOTONIC_USEC=" + std::to_string(base::MonotonicNs() / kNsPerUs));
}

void ServiceManager::TellStopping() const {
  Tell("STOPPING=1");
}

void ServiceManager::TellStatus(const std::string& status) const {
  if (exists_) Tell("STATUS=" + status);
}

void ServiceManager::TellAlive() {
  const std::int64_t now_ns = base::MonotonicNs();
  if (feed_every_ns_ == 0 || now_ns - fed_ns_ < feed_every_ns_) return;
  fed_ns_ = now_ns;
  Tell("WATCHDOG=1");
}

}  // namespace servohil::run
