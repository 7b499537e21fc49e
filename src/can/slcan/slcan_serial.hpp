#pragma once
/// slcan:/dev/...: a real serial CAN adapter.

#include <array>
#include <atomic>
#include <chrono>
#include <string>
#include <string_view>

#include "can/bus.hpp"
#include "can/counters.hpp"
#include "can/file_descriptor.hpp"
#include "can/slcan/slcan_line.hpp"
#include "can/socketcan/interface_state.hpp"

namespace servohil::can {

/// Survives the adapter being pulled out and plugged in: its device is opened again when it comes back.
class SlcanSerial final : public Bus {
 public:
  /// Opens the device raw, and the adapter's channel at the bit rate of the options.
  /// @throws UsageError for a bit rate that the protocol has no code for, EnvironmentError with a hint when
  /// the
  ///         device is missing, not permitted or no terminal
  SlcanSerial(const std::string& device, const BusOptions& options);
  ~SlcanSerial() override;

  const std::string& Name() const noexcept override { return name_; }
  std::string State() const override;
  bool IsVirtual() const noexcept override { return IsTerminalOfAProgram(path_); }
  bool IsGone() const noexcept override { return gone_; }
  int PollFd() noexcept override { return gone_ ? -1 : device_.Get(); }
  std::optional<Frame> Receive() noexcept override;
  SendResult Send(const Frame& frame) noexcept override;
  BusStatistics Statistics() const noexcept override { return counters_.Snapshot(); }

 private:
  std::optional<Frame> NextBufferedFrame() noexcept;
  bool HandleLine(const slcan::Line& line, Frame& frame) noexcept;
  bool WritePending() noexcept;
  void LetGo() noexcept;
  bool Reopen() noexcept;

  std::string path_;
  std::string name_;
  std::uint32_t bit_rate_bit_s_;
  std::string begin_;      ///< what opens the adapter's channel
  FileDescriptor device_;  ///< stays the same number: the other thread may be writing to it
  Counters counters_;
  std::atomic<bool> gone_{false};
  std::atomic<bool> answered_{false};       ///< a line of the protocol has come
  std::atomic<std::uint64_t> refusals_{0};  ///< BELs

  // Receiver thread only.
  slcan::LineAssembler assembler_;
  std::array<char, 4096> input_{};
  std::size_t input_size_ = 0;
  std::size_t input_at_ = 0;
  bool let_go_ = false;
  std::chrono::steady_clock::time_point next_try_;

  // Sender thread only: rest of a line of which the device took a part.
  std::string pending_;
};

}  // namespace servohil::can
