#pragma once
/// SIGINT and SIGTERM (end), SIGHUP (reload) and SIGUSR1 (snapshot) as a descriptor.

#include <sys/signalfd.h>
#include <unistd.h>

#include <csignal>

#include "base/error.hpp"

namespace servohil::run {

/// Constructed before any thread, so that all inherit the blocked mask.
class StopSignals {
 public:
  StopSignals() {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    sigaddset(&set, SIGHUP);
    sigaddset(&set, SIGUSR1);
    pthread_sigmask(SIG_BLOCK, &set, nullptr);
    fd_ = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
    if (fd_ < 0) throw base::EnvironmentError("no signal descriptor: too many open files");
    std::signal(SIGPIPE, SIG_IGN);
  }
  ~StopSignals() { close(fd_); }
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  int Fd() const noexcept { return fd_; }
  /// The next signal that has come; 0: none.
  int Next() const noexcept {
    signalfd_siginfo info{};
    return read(fd_, &info, sizeof info) == sizeof info ? static_cast<int>(info.ssi_signo) : 0;
  }

 private:
  int fd_ = -1;
};

}  // namespace servohil::run
