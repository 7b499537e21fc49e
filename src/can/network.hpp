#pragma once
/// All buses of one run, used as one: what is sent goes to all, what arrives on any is received.
/// Frames that arrive on a virtual segment (slcan:pty) are passed on to the other virtual segments, so that
/// several clients see one another as on one cable. Kernel interfaces are never bridged.
///
/// With a bus model (BusOptions::model) frames take their time and turn, in both directions: what is sent
/// goes out, and what arrived is received, when it would have passed a real bus.

#include <atomic>
#include <chrono>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "can/bus.hpp"

namespace servohil::can {

class Network {
 public:
  /// @throws UsageError, EnvironmentError as OpenBus; UsageError where a bus model is asked for and a bus is
  ///         physical
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
  /// When nobody receives any more: what still waits in the bus model goes out.
  void Flush() noexcept;
  /// At the end of a run: Bus::Drain() of every bus. @return frames that peers do not have
  std::uint64_t Drain() noexcept;

  const std::vector<std::unique_ptr<Bus>>& Buses() const noexcept { return buses_; }
  BusStatistics Statistics() const noexcept;  ///< sum over the buses
  /// Any thread: of the bus model; nothing: there is none.
  std::optional<BusModelStatistics> Modelled() const noexcept;

 private:
  std::optional<Frame> ReceiveNow() noexcept;
  std::optional<Frame> ReceiveThroughModel() noexcept;
  std::optional<Frame> TakePassed() noexcept;
  SendResult SendToAll(const Frame& frame) noexcept;
  void Forward(const Frame& frame) noexcept;
  std::chrono::nanoseconds UntilModelMoves(std::chrono::nanoseconds most) noexcept;
  void WaitForInput(std::chrono::nanoseconds timeout) noexcept;
  void Poke() noexcept;

  std::vector<std::unique_ptr<Bus>> buses_;
  int wake_fd_ = -1;
  std::atomic<bool> woken_{false};
  std::size_t next_ = 0;             ///< bus to look at first: none starves another
  bool nothing_but_errors_ = false;  ///< the last wait ended with errors on descriptors, not with input
  mutable std::mutex model_mutex_;
  std::optional<BusModel> model_;
};

}  // namespace servohil::can
