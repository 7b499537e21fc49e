#include "can/socketcan/socketcan.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <system_error>

#include "base/error.hpp"
#include "can/data_length.hpp"
#include "can/monotonic.hpp"
#include "can/socketcan/interface_state.hpp"

namespace servohil::can {
namespace {

/// The kernel's struct for both formats: can_frame has the same layout as the beginning of canfd_frame.
canfd_frame ToKernel(const Frame& frame) noexcept {
  canfd_frame kernel{};
  kernel.can_id = frame.extended ? (frame.id & CAN_EFF_MASK) | CAN_EFF_FLAG : frame.id & CAN_SFF_MASK;
  const std::size_t size = std::min<std::size_t>(frame.size, frame.fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN);
  kernel.len = kSizeOfCode[CodeOfSize(size)];
  if (frame.error) kernel.can_id = (frame.id & CAN_ERR_MASK) | CAN_ERR_FLAG;
  if (frame.remote) {
    kernel.can_id |= CAN_RTR_FLAG;
  } else {
    std::memcpy(kernel.data, frame.data.data(), size);
  }
  if (frame.fd && frame.bit_rate_switch) kernel.flags = CANFD_BRS;
  return kernel;
}

Frame FromKernel(const canfd_frame& kernel, bool fd) noexcept {
  Frame frame;
  if ((kernel.can_id & CAN_ERR_FLAG) != 0) {
    frame.error = true;
    frame.id = kernel.can_id & CAN_ERR_MASK;
    frame.size = CAN_ERR_DLC;
    std::memcpy(frame.data.data(), kernel.data, frame.size);
    return frame;
  }
  frame.extended = (kernel.can_id & CAN_EFF_FLAG) != 0;
  frame.id = kernel.can_id & (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.remote = (kernel.can_id & CAN_RTR_FLAG) != 0;
  frame.fd = fd;
  frame.bit_rate_switch = fd && (kernel.flags & CANFD_BRS) != 0;
  frame.size = std::min<std::uint8_t>(kernel.len, fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN);
  if (!frame.remote) std::memcpy(frame.data.data(), kernel.data, frame.size);
  return frame;
}

/// What the kernel tells along with a frame.
struct Control {
  std::int64_t time_ns = 0;
  bool has_overflows = false;
  std::uint32_t overflows = 0;  ///< of this socket since it was opened, modulo 2^32
};

Control ReadControl(msghdr& message) noexcept {
  Control control;
  for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr; part = CMSG_NXTHDR(&message, part)) {
    if (part->cmsg_level != SOL_SOCKET) continue;
    if (part->cmsg_type == SO_TIMESTAMPNS) {
      timespec stamp{};
      std::memcpy(&stamp, CMSG_DATA(part), sizeof stamp);
      control.time_ns = stamp.tv_sec * kNsPerS + stamp.tv_nsec;
    } else if (part->cmsg_type == SO_RXQ_OVFL) {
      std::memcpy(&control.overflows, CMSG_DATA(part), sizeof control.overflows);
      control.has_overflows = true;
    }
  }
  return control;
}

}  // namespace

SocketCan::SocketCan(const std::string& interface, const BusOptions& options)
    : interface_(interface),
      name_("socketcan:" + interface),
      is_virtual_(IsVirtualInterface(interface)),
      filters_(KernelFilters(options.wanted)),
      socket_(OpenRawSocket()) {
  CheckInterface(interface, options);
  if (!Attach(socket_.Get(), interface_, filters_)) {
    throw base::EnvironmentError("cannot bind a CAN socket to " + interface + ": " +
                                 std::generic_category().message(errno));
  }
}

std::string SocketCan::State() const {
  return DescribeInterface(interface_);
}

std::optional<Frame> SocketCan::Receive() noexcept {
  if (removed_ && !Attach(socket_.Get(), interface_, filters_)) return std::nullopt;
  removed_ = false;
  constexpr int kMaxSkipped = 64;  // a flood of what is no frame does not keep the caller here
  for (int skipped = 0; skipped < kMaxSkipped; ++skipped) {
    canfd_frame kernel{};
    iovec data{&kernel, sizeof kernel};
    alignas(cmsghdr) std::array<char, 128> control_bytes{};
    msghdr message{};
    message.msg_iov = &data;
    message.msg_iovlen = 1;
    message.msg_control = control_bytes.data();
    message.msg_controllen = control_bytes.size();
    const ssize_t size = ::recvmsg(socket_.Get(), &message, MSG_DONTWAIT);
    if (size < 0) {
      if (errno == EINTR || errno == ENETDOWN) continue;  // down: told once; frames come again after "up"
      removed_ = errno == ENODEV || errno == ENXIO;
      return std::nullopt;
    }
    const Control control = ReadControl(message);
    if (control.has_overflows) {
      Counters::Add(counters_.receive_overflows, control.overflows - kernel_overflows_);
      kernel_overflows_ = control.overflows;
    }
    const bool fd = size == CANFD_MTU;
    if (size != CAN_MTU && !fd) {
      Counters::Add(counters_.malformed);
      continue;
    }
    Counters::Add((kernel.can_id & CAN_ERR_FLAG) != 0 ? counters_.error_frames : counters_.received);
    Frame frame = FromKernel(kernel, fd);
    frame.receive_time_ns = control.time_ns;
    return frame;
  }
  return std::nullopt;
}

SendResult SocketCan::Send(const Frame& frame) noexcept {
  if (in_flight_.AreStuck(socket_.Get())) return counters_.Count(SendResult::kQueueFull);
  const canfd_frame kernel = ToKernel(frame);
  const std::size_t size = frame.fd ? CANFD_MTU : CAN_MTU;
  ssize_t sent = 0;
  do {
    sent = ::send(socket_.Get(), &kernel, size, MSG_DONTWAIT);
  } while (sent < 0 && errno == EINTR);
  if (sent >= 0) {
    in_flight_.AddOne();
    return counters_.Count(SendResult::kSent);
  }
  const bool full = errno == ENOBUFS || errno == EAGAIN || errno == ENOMEM;
  return counters_.Count(full ? SendResult::kQueueFull : SendResult::kDisconnected);
}

}  // namespace servohil::can
