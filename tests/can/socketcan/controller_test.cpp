/// Needs can0 and can1, two controllers on one cable, down, and nobody else on it: those of QEMU's PC in
/// tools/vcan-guest --controllers. A missing one is a failure.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/can/error.h>
#include <poll.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "base/error.hpp"
#include "can/bus.hpp"
#include "can/error_frame.hpp"
#include "can/file_descriptor.hpp"
#include "can/slcan/terminal.hpp"
#include "can/socketcan/interface_state.hpp"
#include "can/socketcan/link.hpp"

namespace servohil::can {
namespace {

const std::string kHere = "can0";
const std::string kThere = "can1";

int Ip(const std::string& arguments) {
  return std::system(("ip link set " + arguments).c_str());
}

std::unique_ptr<Bus> Open(const std::string& interface, const LinkSettings& settings = {}) {
  BusOptions options;
  options.configure = settings;
  return OpenBus("socketcan:" + interface, options);
}

std::string RefusalOf(const LinkSettings& settings) {
  try {
    ConfigureLink(kHere, settings);
  } catch (const base::EnvironmentError& error) {
    return error.what();
  }
  return "not refused";
}

std::string Device(const std::string& interface) {
  return "/sys/class/net/" + interface + "/device/";
}

/// A bit of the adapter's PCI command register, switched over while this lives: an adapter with a defect.
class Defect {
 public:
  enum Bit : std::uint16_t { kDoesNotAnswer = 0x001, kDoesNotInterrupt = 0x400 };

  Defect(const std::string& interface, Bit bit)
      : configuration_(::open((Device(interface) + "config").c_str(), O_RDWR | O_CLOEXEC)), bit_(bit) {
    Toggle();
  }
  Defect(const Defect&) = delete;
  Defect& operator=(const Defect&) = delete;
  ~Defect() { Toggle(); }

 private:
  void Toggle() const {
    constexpr off_t kCommand = 4;
    std::uint16_t command = 0;
    EXPECT_EQ(::pread(configuration_.Get(), &command, sizeof command, kCommand), 2);
    command = static_cast<std::uint16_t>(command ^ bit_);
    EXPECT_EQ(::pwrite(configuration_.Get(), &command, sizeof command, kCommand), 2);
  }

  FileDescriptor configuration_;
  std::uint16_t bit_;
};

TEST(Controller, IsSetUpAsWanted) {
  struct Case {
    LinkSettings wanted;
    double sample_point;
  };
  for (const auto& [wanted, sample_point] :
       {Case{{.bit_rate_bit_s = 500'000, .sample_point = 0.875, .restart_ms = 100, .queue_length = 16},
             0.875},
        Case{{.bit_rate_bit_s = 1'000'000, .sample_point = 0.75, .restart_ms = 0, .queue_length = 1}, 0.75},
        // a bit of 10 quanta: near enough
        Case{{.bit_rate_bit_s = 800'000, .sample_point = 0.82, .restart_ms = 7, .queue_length = 1000}, 0.8},
        Case{{.bit_rate_bit_s = 125'000, .sample_point = 0.0, .restart_ms = 100, .queue_length = 16},
             0.875}}) {
    ConfigureLink(kHere, wanted);
    const auto link = ReadLink(kHere);
    ASSERT_TRUE(link && link->controller);
    EXPECT_TRUE(link->is_can && link->up && !link->takes_fd && !link->IsVirtual());
    EXPECT_EQ(link->kind, "can");
    const Controller& controller = *link->controller;
    EXPECT_EQ(controller.bit_rate_bit_s, wanted.bit_rate_bit_s);
    EXPECT_DOUBLE_EQ(controller.sample_point, sample_point);
    EXPECT_EQ(controller.clock_hz, 8'000'000U);
    EXPECT_EQ(controller.restart_ms, wanted.restart_ms);
    EXPECT_EQ(controller.state, ControllerState::kErrorActive);
    EXPECT_TRUE(controller.has_counters);
    std::uint32_t queue = 0;
    std::ifstream("/sys/class/net/" + kHere + "/tx_queue_len") >> queue;
    EXPECT_EQ(queue, wanted.queue_length);
    EXPECT_EQ(DescribeInterface(kHere),
              "up, " + std::to_string(wanted.bit_rate_bit_s) + " bit/s, error-active");
    EXPECT_EQ(InterfaceBitRate(kHere), wanted.bit_rate_bit_s);
  }
}

TEST(Controller, IsNotSetUpNearlyAsWanted) {
  // 8 MHz / 13
  EXPECT_EQ(RefusalOf({.bit_rate_bit_s = 600'000}),
            "can.bit_rate_bit_s = 600000: the nearest that the controller of can0 can do is 615384 (its "
            "clock: 8000000 Hz)");
  EXPECT_FALSE(IsInterfaceUp(kHere));
  EXPECT_EQ(RefusalOf({.bit_rate_bit_s = 1'000'000, .sample_point = 0.8}),
            "can.sample_point = 0.800: the nearest that the controller of can0 can do at 1000000 bit/s is "
            "0.750 (its clock: 8000000 Hz); set that if it suits the other nodes");
  EXPECT_EQ(
      RefusalOf({.bit_rate_bit_s = 500'000, .sample_point = 0.1}),
      "can.bit_rate_bit_s = 500000 with can.sample_point = 0.100: the controller of can0 cannot do that "
      "(its clock: 8000000 Hz); its range: ip -details link show can0");
  // 64 × 25 quanta of 125 ns: 5000 bit/s is its slowest
  EXPECT_EQ(RefusalOf({.bit_rate_bit_s = 4'000, .sample_point = 0.0}),
            "can.bit_rate_bit_s = 4000: the controller of can0 cannot do that (its clock: 8000000 Hz); its "
            "range: ip -details link show can0");
  EXPECT_EQ(RefusalOf({.bit_rate_bit_s = 5'000, .sample_point = 0.0}), "not refused");
}

TEST(Controller, IsRestartedOnlyAfterBusOff) {
  for (const std::uint32_t restart_ms : {0U, 100U}) {
    ConfigureLink(kHere, {.restart_ms = restart_ms});
    EXPECT_EQ(RestartLink(kHere), RestartResult::kRefused);
    EXPECT_EQ(DescribeInterface(kHere), "up, 500000 bit/s, error-active");  // as it was
  }
  EXPECT_EQ(Ip("can0 down"), 0);
  EXPECT_EQ(RestartLink(kHere), RestartResult::kRefused);
  EXPECT_EQ(RestartLink("can7"), RestartResult::kRefused);
}

TEST(Controller, PassesEveryFrame) {
  const auto here = Open(kHere);
  const auto there = Open(kThere);
  std::uint32_t number = 0;
  for (Bus* const sender : {here.get(), there.get()}) {
    Bus& receiver = sender == here.get() ? *there : *here;
    for (const bool extended : {false, true}) {
      for (std::uint8_t size = 0; size <= 8; ++size) {
        Frame frame = Numbered(++number * 0x01010101, extended ? 0x1ABCDEF0 : 0x7FF);
        frame.extended = extended;
        frame.size = size;
        frame.data[7] = 0xEE;
        EXPECT_EQ(sender->Send(frame), SendResult::kSent);
        const Frame got = PumpFrames(receiver, 1).at(0);
        EXPECT_TRUE(got.id == frame.id && got.extended == extended && got.size == size && !got.remote);
        EXPECT_TRUE(std::equal(frame.data.begin(), frame.data.begin() + size, got.data.begin())) << number;
      }
      Frame remote;
      remote.id = 5;
      remote.extended = extended;
      remote.remote = true;
      EXPECT_EQ(sender->Send(remote), SendResult::kSent);
      EXPECT_TRUE(PumpFrames(receiver, 1).at(0).remote);
    }
  }
  EXPECT_FALSE(here->Receive() || there->Receive());
  EXPECT_EQ(here->Statistics().sent, 20U);
  EXPECT_EQ(here->Statistics().received, 20U);
  EXPECT_EQ(ReadLink(kHere)->tx_packets, ReadLink(kThere)->rx_packets);
}

TEST(Controller, IsNotUsedForCanFd) {
  BusOptions options;
  options.configure = LinkSettings{};
  options.data_bit_rate_bit_s = 2'000'000;
  try {
    OpenBus("socketcan:can0", options);
    FAIL();
  } catch (const base::EnvironmentError& error) {
    EXPECT_STREQ(error.what(),
                 "the DBC has CAN FD messages, and can0 is set up for classic frames only; where its "
                 "controller can: sudo ip link set can0 down; sudo ip link set can0 up type can bitrate "
                 "500000 dbitrate 2000000 fd on");
  }
}

TEST(Controller, IsPhysical) {
  BusOptions options;
  options.allow_physical = false;
  EXPECT_THROW(OpenBus("socketcan:can0", options), base::UsageError);
  EXPECT_FALSE(Open(kHere)->IsVirtual());
}

TEST(Controller, ComesBackAfterItWasPulledOut) {
  const auto here = Open(kHere);
  const auto there = Open(kThere);
  for (int round = 0; round < 3; ++round) {
    const int index = ReadLink(kHere)->index;
    std::ofstream(Device(kHere) + "remove") << 1;
    EXPECT_EQ(here->State(), "gone");
    EXPECT_EQ(here->Send(Numbered(1)), SendResult::kDisconnected);
    EXPECT_FALSE(here->Receive());
    std::ofstream("/sys/bus/pci/rescan") << 1;
    EXPECT_EQ(here->State(), "down");
    EXPECT_NE(ReadLink(kHere)->index, index);
    ConfigureLink(kHere, {});
    EXPECT_FALSE(here->Receive());  // finds it again
    EXPECT_EQ(here->Send(Numbered(2)), SendResult::kSent);
    EXPECT_EQ(NumberOf(PumpFrames(*there, 1).at(0)), 2U);
    there->Send(Numbered(3));
    EXPECT_EQ(NumberOf(PumpFrames(*here, 1).at(0)), 3U);
  }
}

/// Its buffer of 64 bytes holds five frames of 3 + 8.
TEST(Controller, TellsThatItsBufferWasFull) {
  const auto here = Open(kHere);
  const auto there = Open(kThere);
  {
    const Defect defect(kHere, Defect::kDoesNotInterrupt);
    for (std::uint32_t number = 0; number < 9; ++number) {
      there->Send(Numbered(number));
      while (there->Statistics().sent > ReadLink(kThere)->tx_packets) ::poll(nullptr, 0, 1);
    }
    EXPECT_FALSE(here->Receive());
  }
  const std::vector<Frame> got = PumpFrames(*here, 6);
  ErrorTotals errors;
  std::uint32_t number = 0;
  for (const Frame& frame : got) {
    if (frame.error) {
      errors.Take(frame);
    } else {
      EXPECT_EQ(NumberOf(frame), number++);
    }
  }
  EXPECT_EQ(number, 5U);
  EXPECT_EQ(errors.controller_overflows, 1U);
  EXPECT_EQ(errors.DescribeLast(), "controller-problem{rx-overflow}");
}

/// A controller that does not finish a frame: what waits behind it is not added to.
TEST(Controller, IsNotSentToWhileItHoldsAFrame) {
  const auto here = Open(kHere, {.queue_length = 4});
  const auto there = Open(kThere);
  std::uint32_t sent = 0;
  {
    const Defect defect(kHere, Defect::kDoesNotInterrupt);
    while (sent < 100 && here->Send(Numbered(sent)) == SendResult::kSent) ++sent;
    EXPECT_GE(sent, 1U);
    EXPECT_LE(sent, 4U + 2U);  // four in the queue, one on its way, one in the controller
    ::poll(nullptr, 0, 30);
    EXPECT_EQ(here->Send(Numbered(100)), SendResult::kQueueFull);
  }
  const std::vector<Frame> got = PumpFrames(*there, sent);
  for (std::uint32_t number = 0; number < sent; ++number) EXPECT_EQ(NumberOf(got.at(number)), number);
  while (here->Send(Numbered(200)) == SendResult::kQueueFull) ::poll(nullptr, 0, 1);
  EXPECT_EQ(NumberOf(PumpFrames(*there, 1).at(0)), 200U);
}

}  // namespace
}  // namespace servohil::can
