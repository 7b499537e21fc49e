#pragma once
/// All buses of one run, used as one: what is sent goes to all, what arrives on any is received.
/// Frames that arrive on a virtual segment (slcan:pty) are passed on to the other virtual segments, so that
/// several clients see one another as on one cable. Kernel interfaces are never bridged.

#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "servohil/can/bus.hpp"

namespace servohil::can {

class Network {
 public:
  /// @throws UsageError, EnvironmentError as OpenBus
  Network(const std::vector<std::string>& urls, const BusOptions& options);
  ~Network();
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  /// Receiver thread only. Waits for a frame until Wake() (then nothing; stays woken) or `timeout_ms`
  /// (negative: without end; 0: not at all).
  std::optional<Frame> Receive(int timeout_ms) noexcept;
  /// Ends a Receive() that waits; safe from any thread and from signal handlers.
  void Wake() noexcept;
  /// Sender thread only. Sends to every bus. The worst result of all.
  SendResult Send(const Frame& frame) noexcept;

  const std::vector<std::unique_ptr<Bus>>& Buses() const noexcept { return buses_; }
  BusStatistics Statistics() const noexcept;  ///< sum over the buses

 private:
  std::optional<Frame> ReceiveNow() noexcept;
  void Forward(const Frame& frame, std::size_t from) noexcept;
  void WaitForInput(int timeout_ms) noexcept;

  std::vector<std::unique_ptr<Bus>> buses_;
  int wake_fd_ = -1;
  std::atomic<bool> woken_{false};
  std::size_t next_ = 0;             ///< bus to look at first: none starves another
  bool nothing_but_errors_ = false;  ///< the last wait ended with errors on descriptors, not with input
};

}  // namespace servohil::can
