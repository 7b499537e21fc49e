/// Needs vcan0, up and otherwise quiet, and the right to take it down. A missing one is a failure: run it by
/// tools/vcan-guest, or where the kernel has vcan.

#include <gtest/gtest.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <thread>

#include "base/error.hpp"
#include "can/bus.hpp"
#include "can/dbc/error_of.hpp"
#include "can/network.hpp"
#include "can/slcan/terminal.hpp"
#include "can/socketcan/interface_state.hpp"
#include "can/socketcan/link.hpp"

namespace servohil::can {
namespace {

const std::string kInterface = "vcan0";
const std::string kUrl = "socketcan:vcan0";
constexpr int kPatienceMs = 20'000;

void Switch(const std::string& interface, bool up) {
  ifreq request{};
  std::memcpy(request.ifr_name, interface.c_str(), interface.size() + 1);
  const FileDescriptor any_socket(::socket(AF_UNIX, SOCK_DGRAM, 0));
  ASSERT_EQ(::ioctl(any_socket.Get(), SIOCGIFFLAGS, &request), 0) << std::strerror(errno);
  request.ifr_flags = static_cast<short>(up ? request.ifr_flags | IFF_UP : request.ifr_flags & ~IFF_UP);
  ASSERT_EQ(::ioctl(any_socket.Get(), SIOCSIFFLAGS, &request), 0) << std::strerror(errno);
}

bool Same(const Frame& a, const Frame& b) {
  return a.id == b.id && a.extended == b.extended && a.remote == b.remote && a.fd == b.fd &&
         a.bit_rate_switch == b.bit_rate_switch && a.size == b.size && a.data == b.data;
}

std::int64_t NowNs() {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  return now.tv_sec * 1'000'000'000LL + now.tv_nsec;
}

double ThreadCpuSeconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

TEST(SocketCan, SendsAndReceivesEveryFormat) {
  const auto sender = OpenBus(kUrl, {});
  const auto receiver = OpenBus(kUrl, {});
  for (const bool extended : {false, true}) {
    for (const bool fd : {false, true}) {
      Frame frame = Numbered(0x12345678, extended ? 0x1ABCDEF0 : 0x7FF);
      frame.extended = extended;
      frame.fd = fd;
      frame.bit_rate_switch = fd;
      frame.size = fd ? 64 : 8;
      frame.data[frame.size - 1U] = 0xEE;
      EXPECT_EQ(sender->Send(frame), SendResult::kSent);
      const std::vector<Frame> got = PumpFrames(*receiver, 1);
      ASSERT_EQ(got.size(), 1U);
      EXPECT_TRUE(Same(got[0], frame)) << extended << fd;
    }
  }
  Frame remote;
  remote.id = 5;
  remote.remote = true;
  remote.size = 4;
  EXPECT_EQ(sender->Send(remote), SendResult::kSent);
  EXPECT_TRUE(Same(PumpFrames(*receiver, 1).at(0), remote));
  EXPECT_EQ(sender->Statistics().sent, 5U);
  EXPECT_EQ(receiver->Statistics().received, 5U);
}

TEST(SocketCan, AnFdSizeWithoutCodeGoesUpToTheNext) {
  const auto sender = OpenBus(kUrl, {});
  const auto receiver = OpenBus(kUrl, {});
  Frame frame;
  frame.fd = true;
  frame.size = 10;
  frame.data.fill(0xAA);
  sender->Send(frame);
  const Frame got = PumpFrames(*receiver, 1).at(0);
  EXPECT_EQ(got.size, 12);
  EXPECT_EQ(got.data[9], 0xAA);
  EXPECT_EQ(got.data[10], 0);
}

TEST(SocketCan, DoesNotReceiveItsOwnFrames) {
  const auto bus = OpenBus(kUrl, {});
  const auto witness = OpenBus(kUrl, {});
  bus->Send(Numbered(1));
  EXPECT_EQ(PumpFrames(*witness, 1).size(), 1U);
  EXPECT_FALSE(bus->Receive());
}

TEST(SocketCan, TheKernelPassesExactlyTheWantedDataFrames) {
  BusOptions options;
  options.wanted = {{0x100, false}, {0x200, true}};
  const auto bus = OpenBus(kUrl, options);
  const auto sender = OpenBus(kUrl, {});
  const auto send = [&](std::uint32_t id, bool extended, bool remote) {
    Frame frame = Numbered(id, id);
    frame.extended = extended;
    frame.remote = remote;
    if (remote) frame.data = {};
    EXPECT_EQ(sender->Send(frame), SendResult::kSent);
  };
  for (const std::uint32_t id : {0x100U, 0x101U, 0x200U, 0x000U}) {
    for (const bool extended : {false, true}) {
      for (const bool remote : {false, true}) send(id, extended, remote);
    }
  }
  const std::vector<Frame> got = PumpFrames(*bus, 2);
  ASSERT_EQ(got.size(), 2U);
  EXPECT_TRUE(got[0].id == 0x100 && !got[0].extended && !got[0].remote);
  EXPECT_TRUE(got[1].id == 0x200 && got[1].extended && !got[1].remote);
  EXPECT_FALSE(bus->Receive());
}

TEST(SocketCan, TheKernelStampsTheTime) {
  const auto sender = OpenBus(kUrl, {});
  const auto receiver = OpenBus(kUrl, {});
  const std::int64_t before = NowNs();
  sender->Send(Numbered(1));
  const std::int64_t after = NowNs();
  const Frame frame = PumpFrames(*receiver, 1).at(0);
  EXPECT_GE(frame.receive_time_ns, before);
  EXPECT_LE(frame.receive_time_ns, after);
}

TEST(SocketCan, CountsWhatTheKernelDropsBecauseNobodyReads) {
  constexpr std::uint32_t kFrames = 5'000;  // a receive buffer of 212,992 bytes holds a few hundred
  const auto sender = OpenBus(kUrl, {});
  const auto receiver = OpenBus(kUrl, {});
  for (std::uint32_t i = 0; i < kFrames; ++i) {
    while (sender->Send(Numbered(i)) == SendResult::kQueueFull) ::poll(nullptr, 0, 1);
  }
  std::uint64_t received = 0;
  while (receiver->Receive()) ++received;
  ASSERT_LT(received, kFrames);
  sender->Send(Numbered(kFrames));  // the counter comes with the next frame
  EXPECT_EQ(NumberOf(PumpFrames(*receiver, 1).at(0)), kFrames);
  EXPECT_EQ(receiver->Statistics().receive_overflows, kFrames - received);
}

TEST(SocketCan, SurvivesTheInterfaceBeingTakenDownAndUp) {
  BusOptions options;
  options.wanted = {{0x100, false}};
  Network network({kUrl}, options);
  for (int round = 0; round < 3; ++round) {
    Switch(kInterface, false);
    EXPECT_EQ(network.Send(Numbered(1)), SendResult::kDisconnected);
    EXPECT_EQ(network.Buses()[0]->State(), "down");
    const double before = ThreadCpuSeconds();
    EXPECT_FALSE(network.Receive(300));
    EXPECT_LT(ThreadCpuSeconds() - before, 0.1);  // it waits, it does not spin
    Switch(kInterface, true);
    EXPECT_EQ(network.Buses()[0]->State(), "up, virtual");
    EXPECT_EQ(network.Send(Numbered(2)), SendResult::kSent);
    const auto peer = OpenBus(kUrl, {});
    peer->Send(Numbered(9, 0x101));  // the filter is still there
    peer->Send(Numbered(3, 0x100));
    const auto frame = network.Receive(kPatienceMs);
    ASSERT_TRUE(frame);
    EXPECT_EQ(NumberOf(*frame), 3U);
  }
  EXPECT_EQ(network.Statistics().dropped_disconnected, 3U);
  EXPECT_EQ(network.Statistics().malformed, 0U);
}

int Ip(const std::string& arguments) {
  return std::system(("ip " + arguments).c_str());
}

TEST(SocketCan, SurvivesTheInterfaceBeingRemovedAndMadeAnew) {
  ASSERT_EQ(Ip("link add dev vcan9 type vcan"), 0);
  ASSERT_EQ(Ip("link set vcan9 up"), 0);
  BusOptions options;
  options.wanted = {{0x100, false}};
  Network network({"socketcan:vcan9"}, options);
  ASSERT_EQ(Ip("link del vcan9"), 0);
  EXPECT_FALSE(network.Receive(50));
  EXPECT_EQ(network.Send(Numbered(1)), SendResult::kDisconnected);
  EXPECT_EQ(network.Buses()[0]->State(), "gone");
  ASSERT_EQ(Ip("link add dev vcan9 type vcan"), 0);
  ASSERT_EQ(Ip("link set vcan9 up"), 0);
  EXPECT_FALSE(network.Receive(50));
  EXPECT_EQ(network.Send(Numbered(2)), SendResult::kSent);
  const auto peer = OpenBus("socketcan:vcan9", {});
  peer->Send(Numbered(9, 0x101));  // the kernel has forgotten the filter: it must have been set again
  peer->Send(Numbered(3, 0x100));
  const auto frame = network.Receive(kPatienceMs);
  ASSERT_TRUE(frame);
  EXPECT_EQ(NumberOf(*frame), 3U);
  EXPECT_EQ(Ip("link del vcan9"), 0);
}

TEST(SocketCan, SaysWhatIsMissing) {
  EXPECT_EQ(
      ErrorOf<base::EnvironmentError>("socketcan:vcan7"),
      "no CAN interface vcan7; make it: sudo ip link add dev vcan7 type vcan && sudo ip link set up vcan7");
  EXPECT_EQ(ErrorOf<base::EnvironmentError>("socketcan:can7"),
            "no such interface can7: is the adapter plugged in? This lists what there is: ip -br link show "
            "type can");
  EXPECT_EQ(ErrorOf<base::EnvironmentError>("socketcan:lo"),
            "lo is not a CAN interface; this lists them: ip -br link show type can");
  Switch(kInterface, false);
  EXPECT_EQ(ErrorOf<base::EnvironmentError>(kUrl),
            "CAN interface vcan0 is down; set it up: sudo ip link set vcan0 up");
  Switch(kInterface, true);
  EXPECT_EQ(ErrorOf<base::EnvironmentError>("socketcan:a_name_longer_than_the_kernel_takes").substr(0, 17),
            "no such interface");
}

TEST(SocketCan, KnowsTheStateAndPrintsNothing) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(DescribeInterface(kInterface), "up, virtual");
  EXPECT_FALSE(InterfaceBitRate(kInterface));
  EXPECT_TRUE(IsCanInterface(kInterface));
  EXPECT_TRUE(IsInterfaceUp(kInterface));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(SocketCan, AVirtualInterfaceHasNoControllerToSetUp) {
  ::testing::internal::CaptureStderr();
  EXPECT_FALSE(ReadController("vcan0"));
  EXPECT_FALSE(SetBitTiming("vcan0", 500'000, 0.875));
  EXPECT_FALSE(SetRestartMs("vcan0", 100));
  EXPECT_FALSE(Restart("vcan0"));
  EXPECT_TRUE(can::SetUp("vcan0", true));
  EXPECT_EQ(ReadLink("vcan0")->kind, "vcan");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

TEST(SocketCan, AutomaticUrlIsTheFirstInterfaceThatIsThere) {
  const std::vector<std::string> interfaces{"can0", "lo", "vcan0"};
  EXPECT_EQ(AutomaticUrl(interfaces), kUrl);
}

TEST(SocketCan, IsNotBridgedToTerminals) {
  Network network({kUrl, "slcan:pty"}, {});
  const Client client(network.Buses()[1]->Name().substr(6));
  client.Write("O\r");
  while (network.Buses()[1]->State() != "client connected, channel open") network.Receive(1);
  const auto peer = OpenBus(kUrl, {});
  client.Write("t1230\r");
  ASSERT_TRUE(network.Receive(kPatienceMs));
  EXPECT_FALSE(peer->Receive());
  peer->Send(Numbered(1));
  ASSERT_TRUE(network.Receive(kPatienceMs));
  EXPECT_EQ(client.ReadUntil("z\r"), "\rz\r");
  EXPECT_EQ(client.Read(), "");
  EXPECT_EQ(network.Send(Numbered(2)), SendResult::kSent);  // but what we send goes to both
  EXPECT_EQ(PumpFrames(*peer, 1).size(), 1U);
  EXPECT_EQ(client.ReadUntil("\r").front(), 't');
}

}  // namespace
}  // namespace servohil::can
