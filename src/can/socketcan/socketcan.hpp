#pragma once
/// A kernel CAN interface: PF_CAN raw socket.

#include <linux/can.h>

#include <cstdint>
#include <string>
#include <vector>

#include "can/bus.hpp"
#include "can/counters.hpp"
#include "can/file_descriptor.hpp"
#include "can/socketcan/frames_in_flight.hpp"

namespace servohil::can {

/// The kernel's form of a list of wanted ids: exactly these data frames; everything when the list is empty.
std::vector<can_filter> KernelFilters(const std::vector<WantedId>& wanted);

/// A raw socket with its options set, not yet bound.
/// @throws EnvironmentError with the command that helps
FileDescriptor OpenRawSocket();
/// Checks that the interface may be used, sets it up where that is asked for.
/// @throws UsageError where it is physical and must not be; EnvironmentError with the command that helps,
/// where
///         it is missing, of another kind or down
void CheckInterface(const std::string& interface, const BusOptions& options);
/// Sets the receive filter and binds to the interface, which must exist: index 0 would bind to all of them.
/// The kernel forgets both when it removes an interface. @return success
bool Attach(int socket, const std::string& interface, const std::vector<can_filter>& filters) noexcept;

/// Survives the interface being taken down and up, and (an adapter plugged out and in) removed and made anew.
///
/// Sends nothing while frames are stuck in the transmit queue or the controller: what is sent after an outage
/// is never older than kMaxAgeNs before its begin.
class SocketCan final : public Bus {
 public:
  /// @throws EnvironmentError
  SocketCan(const std::string& interface, const BusOptions& options);

  const std::string& Name() const noexcept override { return name_; }
  std::string Interface() const override { return interface_; }
  std::string State() const override;
  bool IsVirtual() const noexcept override { return is_virtual_; }
  const char* WhyNoErrorFrames() const noexcept override {
    return IsVirtual() ? nullptr : "a real CAN controller would send them as data frames";
  }
  int PollFd() noexcept override { return removed_ ? -1 : socket_.Get(); }
  std::optional<Frame> Receive() noexcept override;
  SendResult Send(const Frame& frame) noexcept override;
  BusStatistics Statistics() const noexcept override { return counters_.Snapshot(); }

 private:
  std::string interface_;
  std::string name_;
  bool is_virtual_;
  std::vector<can_filter> filters_;
  FileDescriptor socket_;
  FramesInFlight in_flight_;            ///< sender thread only
  bool removed_ = false;                ///< receiver thread only: the kernel has unbound the socket
  std::uint32_t kernel_overflows_ = 0;  ///< the kernel's counter when last seen; it wraps
  Counters counters_;
};

}  // namespace servohil::can
