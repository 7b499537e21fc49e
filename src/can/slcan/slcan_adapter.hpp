#pragma once
/// slcan:pty: a pseudo-terminal that plays a serial CAN adapter with the emulator on its bus.

#include <array>
#include <atomic>
#include <mutex>
#include <string>

#include "can/bus.hpp"
#include "can/counters.hpp"
#include "can/slcan/pty.hpp"
#include "can/slcan/pty_link.hpp"
#include "can/slcan/slcan_line.hpp"
#include "can/slcan/slcan_outbox.hpp"
#include "can/slcan/slcan_session.hpp"

namespace servohil::can {

/// The client gets frames only while it has its channel open, so nothing old bursts out when it connects. A
/// client that vanishes (killed, unplugged) closes the channel. One that does not read loses old frames, not
/// new ones.
class SlcanAdapter final : public Bus {
 public:
  /// @throws UsageError, EnvironmentError as PtyLink and Pty
  explicit SlcanAdapter(const std::string& link);
  ~SlcanAdapter() override;

  const std::string& Name() const noexcept override { return name_; }
  std::string ConnectHint() const override;
  std::string State() const override;
  bool IsVirtualSegment() const noexcept override { return true; }
  int PollFd() noexcept override { return connected_ ? pty_.Fd() : -1; }
  std::optional<Frame> Receive() noexcept override;
  SendResult Send(const Frame& frame) noexcept override;
  std::uint64_t Drain() noexcept override;
  BusStatistics Statistics() const noexcept override { return counters_.Snapshot(); }

 private:
  std::optional<Frame> NextBufferedFrame();
  std::optional<Frame> HandleLine(const slcan::Line& line);
  void Disconnect();

  Pty pty_;
  PtyLink link_;
  std::string path_;  ///< the link, or the terminal itself
  std::string name_;
  Counters counters_;
  std::atomic<bool> connected_{false};  ///< somebody has the terminal open; set by the receiver thread

  // Receiver thread only.
  slcan::LineAssembler assembler_;
  std::array<char, 4096> input_{};
  std::size_t input_size_ = 0;
  std::size_t input_at_ = 0;

  /// Keeps lines whole: the receiver thread writes answers, the sender thread frames.
  mutable std::mutex mutex_;
  slcan::Session session_;
  slcan::Outbox outbox_{pty_};
};

}  // namespace servohil::can
