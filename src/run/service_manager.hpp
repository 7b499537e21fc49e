#pragma once
/// What systemd is told of a run (sd_notify). Without it nothing happens.

#include <cstdint>
#include <string>

namespace servohil::run {

/// One thread.
class ServiceManager {
 public:
  /// Reads how often the watchdog wants to be fed.
  ServiceManager();

  /// Somebody is told.
  bool Exists() const noexcept { return exists_; }
  void TellReady() const;
  /// Until TellReady().
  void TellReloading() const;
  void TellStopping() const;
  /// @param status  one line for people: what `systemctl status` shows
  void TellStatus(const std::string& status) const;
  /// The loop has gone on since the last call: the watchdog is fed, as often as it needs.
  void TellAlive();

 private:
  bool exists_;
  std::int64_t feed_every_ns_ = 0;  ///< 0: no watchdog
  std::int64_t fed_ns_ = 0;
};

}  // namespace servohil::run
