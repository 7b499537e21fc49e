#pragma once
/// The bus as the emulator sees it: one interface, a transport behind each URL.
///
///   socketcan:IFACE        a kernel CAN interface (can0, vcan0)
///   slcan:pty[:LINK]       a new pseudo-terminal that plays a serial CAN adapter with the emulator on its
///   bus;
///                          LINK is a symbolic link to it, for a name that stays the same
///   slcan:/dev/ttyACM0     a real serial CAN adapter
///
/// A bus that real machines may be on (whatever is not vcan, vxcan or a pseudo-terminal) is physical.

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "can/bus_model.hpp"
#include "can/frame.hpp"
#include "can/socketcan/link.hpp"

namespace servohil::can {

/// Identifier of a frame that the emulator wants to receive.
struct WantedId {
  std::uint32_t id = 0;
  bool extended = false;
  std::uint32_t mask = 0x1FFF'FFFF;  ///< bits of the identifier that count
};

struct BusOptions {
  /// Kernel receive filter (socketcan): exactly these data frames, everything when empty. Error frames always
  /// pass. Others pass everything.
  std::vector<WantedId> wanted;
  std::uint32_t bit_rate_bit_s = 500'000;  ///< told to a real serial adapter (S0..S8)
  std::uint32_t data_bit_rate_bit_s = 0;   ///< CAN FD frames are used, at this rate; 0: none are
  bool allow_physical = true;              ///< else a physical bus is refused
  std::optional<LinkSettings> configure;   ///< sets up kernel interfaces before they are used
  std::optional<BusModelSettings> model;   ///< all buses together behave as one real bus; virtual ones only
};

enum class SendResult : std::uint8_t {
  kSent,
  kQueueFull,     ///< dropped: transmit queue or terminal buffer full, or frames stuck in it
  kDisconnected,  ///< dropped: interface down, or no client has opened the channel
};

/// Totals since the bus was opened.
struct BusStatistics {
  std::uint64_t received = 0;  ///< frames delivered by Receive()
  std::uint64_t sent = 0;      ///< frames accepted by the transport
  /// Frames lost to a full queue: refused, or (slcan:pty) accepted earlier and discarded because the client
  /// did not read; those are in `sent` as well.
  std::uint64_t dropped_queue_full = 0;
  std::uint64_t dropped_disconnected = 0;
  std::uint64_t receive_overflows = 0;  ///< frames the kernel dropped because we read too slowly
  std::uint64_t malformed = 0;          ///< input that is not a frame (serial line noise)
  std::uint64_t error_frames = 0;       ///< delivered by Receive(), not among `received`
};

/// How long Drain() waits for a peer that reads nothing, and for one that reads slowly.
inline constexpr std::chrono::milliseconds kDrainStalled{2'000};
inline constexpr std::chrono::milliseconds kDrainLongest{10'000};
/// How long the line stays open for a peer that has read everything: python-can looks for more before it hands out what it has
/// read, one frame at a time, and loses that where the line is broken.
inline constexpr std::chrono::milliseconds kDrainLinger{250};

/// One thread may call Receive() and PollFd() while another calls Send(); Statistics() and State() may be
/// called from any. Send() of a virtual segment may be called from several threads. Nothing but opening
/// throws.
class Bus {
 public:
  Bus() = default;
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;
  virtual ~Bus() = default;

  /// "socketcan:vcan0", "slcan:/dev/pts/3": what a user would call it.
  virtual const std::string& Name() const noexcept = 0;
  /// The kernel's interface behind it; empty where there is none.
  virtual std::string Interface() const { return {}; }
  /// An adapter's device has been removed. (Of a kernel's interface, ask the kernel.)
  virtual bool IsGone() const noexcept { return false; }
  /// How a peer connects, one line; empty where Name() says it all.
  virtual std::string ConnectHint() const { return {}; }
  /// Interface state for people ("up, 500000 bit/s, error-active"), where the transport has one.
  virtual std::string State() const { return {}; }
  /// A virtual segment: frames from one of these are passed on to the others, as on one cable.
  virtual bool IsVirtualSegment() const noexcept { return false; }

  /// Why frames with `error` set cannot be sent; null: they can.
  virtual const char* WhyNoErrorFrames() const noexcept {
    return "serial CAN adapters (slcan) have no error frames";
  }

  /// Nothing but programs on this machine can be on it.
  virtual bool IsVirtual() const noexcept { return IsVirtualSegment(); }

  /// Descriptor to poll for input; -1 while there is nothing to poll (no client, device gone). Receive() then
  /// still may be called, every few milliseconds, and finds a client that has come.
  virtual int PollFd() noexcept = 0;
  /// Next frame, an error frame perhaps, or nothing when there is none now. Never blocks.
  virtual std::optional<Frame> Receive() noexcept = 0;
  /// Never blocks.
  virtual SendResult Send(const Frame& frame) noexcept = 0;

  /// At the end of a run, when nobody sends any more: waits until the peer has what was sent, for a bounded
  /// time (kDrainStalled, kDrainLongest). @return frames that it does not have
  virtual std::uint64_t Drain() noexcept { return 0; }

  virtual BusStatistics Statistics() const noexcept = 0;
};

/// @throws UsageError for a URL of no known form, or a physical bus that is not allowed; EnvironmentError
/// (with
///         the command that helps) when the interface, device or permission is missing.
std::unique_ptr<Bus> OpenBus(const std::string& url, const BusOptions& options);

/// Only the form of the URL, "auto" included: opens nothing. @throws UsageError as OpenBus
void CheckUrl(const std::string& url);

/// What `--can auto` means on this machine: the first of `interfaces` that the kernel has, physical ones only
/// where that is allowed, else "slcan:pty".
std::string AutomaticUrl(std::span<const std::string> interfaces, bool allow_physical = true);

/// "slcan:/dev/ttyACM0 is a physical bus: ..."
std::string PhysicalRefusal(const std::string& url);

}  // namespace servohil::can
