#include <gtest/gtest.h>
#include <sys/socket.h>

#include <array>

#include "base/error.hpp"
#include "can/bus.hpp"
#include "can/dbc/error_of.hpp"
#include "can/file_descriptor.hpp"
#include "can/socketcan/interface_state.hpp"

namespace servohil::can {
namespace {

TEST(OpenBus, SaysWhatItExpects) {
  const std::string expected = ": expected socketcan:IFACE, slcan:pty[:LINK] or slcan:/dev/DEVICE";
  for (const std::string url : {"", "socketcan:", "slcan:", "slcan:pty:", "slcan:ptyx", "slcan:ttyACM0"}) {
    EXPECT_EQ(ErrorOf<base::UsageError>(url), "unknown bus '" + url + "'" + expected) << url;
  }
  EXPECT_EQ(ErrorOf<base::UsageError>("pty"), "unknown bus 'pty'" + expected + "; did you mean slcan:pty?");
  EXPECT_EQ(ErrorOf<base::UsageError>("can0"),
            "unknown bus 'can0'" + expected + "; did you mean socketcan:can0?")
      << "there or not";
  EXPECT_EQ(ErrorOf<base::UsageError>("/dev/ttyACM0"),
            "unknown bus '/dev/ttyACM0'" + expected + "; did you mean slcan:/dev/ttyACM0?");
}

TEST(OpenBus, NamesTheCommandThatMakesAMissingInterface) {
  const FileDescriptor can(::socket(PF_CAN, SOCK_RAW, 1));
  if (!can) {
    EXPECT_EQ(ErrorOf<base::EnvironmentError>("socketcan:vcan0"),
              "this kernel has no CAN (where it has the modules: sudo modprobe -a can_raw vcan); use --can "
              "slcan:pty "
              "instead");
  } else {
    EXPECT_EQ(ErrorOf<base::EnvironmentError>("socketcan:vcan77"),
              "no CAN interface vcan77; make it: sudo ip link add dev vcan77 type vcan && sudo ip link set "
              "up vcan77");
  }
}

TEST(AutomaticUrl, IsTheTerminalWhereNoInterfaceIsCan) {
  EXPECT_EQ(AutomaticUrl({}), "slcan:pty");
  const std::array<std::string, 3> none{"lo", "no_such_if", "a_name_longer_than_the_kernel_takes"};
  EXPECT_EQ(AutomaticUrl(none), "slcan:pty");  // lo is there, but no CAN interface
}

TEST(InterfaceState, OfWhatIsNoCanInterface) {
  EXPECT_FALSE(IsCanInterface("lo"));
  EXPECT_FALSE(InterfaceBitRate("lo"));
  EXPECT_EQ(DescribeInterface("no_such_if"), "gone");
}

}  // namespace
}  // namespace servohil::can
