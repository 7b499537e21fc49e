#pragma once
/// Frames that a socket has accepted and that are not on the bus yet: in the interface's queue, or in a
/// controller whom nobody acknowledges.

#include <array>
#include <cstddef>
#include <cstdint>

namespace servohil::can {

/// One thread.
class FramesInFlight {
 public:
  /// The oldest waits for longer than kMaxAgeNs: another one would only become old behind it. As the kernel
  /// accounts for the socket's memory; where it does not tell, none is ever stuck.
  bool AreStuck(int socket) noexcept;
  /// One more has been accepted, now.
  void AddOne() noexcept;

  /// What governors may take for the present: two cycles of the fastest message that is usual.
  static constexpr std::int64_t kMaxAgeNs = 20'000'000;

 private:
  static constexpr std::size_t kMost =
      256;  ///< more than any queue of a CAN interface; the rest is not young

  std::array<std::int64_t, kMost> sent_ns_{};  ///< when the newest ones were accepted, in a circle
  std::size_t next_ = 0;
  std::uint32_t frame_bytes_ = 0;  ///< that one frame takes, as seen: 0: none yet
};

}  // namespace servohil::can
