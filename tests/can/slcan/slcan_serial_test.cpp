#include "can/slcan/slcan_serial.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "base/error.hpp"
#include "can/slcan/pty.hpp"
#include "can/slcan/slcan_adapter.hpp"
#include "terminal.hpp"

namespace servohil::can {
namespace {

/// A device that does nothing by itself.
class SlcanSerialTest : public testing::Test {
 protected:
  std::string Read(std::size_t size) {
    std::string text;
    Pump(bus_, [&](const auto&) {
      std::array<char, 256> buffer{};
      const std::ptrdiff_t got = device_->Read(buffer);
      if (got > 0) text.append(buffer.data(), static_cast<std::size_t>(got));
      return text.size() >= size;
    });
    return text;
  }

  std::unique_ptr<Pty> device_ = std::make_unique<Pty>();
  SlcanSerial bus_{device_->SlavePath(), BusOptions{}};
};

TEST_F(SlcanSerialTest, SetsTheBitRateAndOpens) {
  EXPECT_EQ(Read(9), "\r\rC\rS6\rO\r");
  EXPECT_EQ(bus_.State(), "500000 bit/s, no answer from the adapter yet");
}

TEST_F(SlcanSerialTest, ReadsFramesAndCountsTheRest) {
  device_->Write("\r\r\a\r\rt1232AABBEA5F\rz\rZ\rzt1230\rnoise\rt12\r");
  const std::vector<Frame> frames = PumpFrames(bus_, 2);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].data[1], 0xBB);
  Pump(bus_, [&](const auto&) { return bus_.Statistics().malformed >= 3; });
  EXPECT_EQ(bus_.Statistics().malformed, 3U);  // BEL, noise, cut frame
  EXPECT_EQ(bus_.Statistics().received, 2U);
  EXPECT_EQ(bus_.State(), "500000 bit/s, commands refused: 1");
}

TEST_F(SlcanSerialTest, SendsWholeLinesThoughTheDeviceStalls) {
  Read(9);
  std::uint32_t sent = 0;
  while (bus_.Send(Numbered(sent)) == SendResult::kSent) ++sent;
  EXPECT_EQ(bus_.Statistics().dropped_queue_full, 1U);
  std::string text = Read(22U * (sent - 1));
  while (bus_.Send(Numbered(sent)) != SendResult::kSent) text += Read(0);
  text += Read(22U * (sent + 1) - text.size());
  ASSERT_EQ(text.size(), 22U * (sent + 1));
  for (std::size_t at = 0; at < text.size(); at += 22) {
    ASSERT_EQ(text.substr(at, 5), "t1008") << at;
    ASSERT_EQ(text[at + 21], '\r') << at;
  }
}

TEST_F(SlcanSerialTest, SurvivesTheDeviceBeingPulledOut) {
  device_.reset();
  Pump(bus_, [&](const auto&) { return bus_.PollFd() == -1; });
  EXPECT_EQ(bus_.Send(Numbered(0)), SendResult::kDisconnected);
  EXPECT_FALSE(bus_.Receive());
  EXPECT_EQ(bus_.State(), "device gone");
}

TEST_F(SlcanSerialTest, NoticesInSendingToo) {
  device_.reset();
  EXPECT_EQ(bus_.Send(Numbered(0)), SendResult::kDisconnected);
  EXPECT_EQ(bus_.PollFd(), -1);
}

TEST(SlcanSerial, TalksToOurOwnAdapter) {
  SlcanAdapter adapter("");
  SlcanSerial serial(adapter.Name().substr(6), BusOptions{});
  PumpUntilState(adapter, "client connected, channel open");
  Frame fd = Numbered(7);
  fd.fd = true;
  fd.extended = true;
  fd.size = 64;
  EXPECT_EQ(serial.Send(fd), SendResult::kSent);
  const std::vector<Frame> out = PumpFrames(adapter, 1);
  ASSERT_EQ(out.size(), 1U);
  EXPECT_EQ(out[0].size, 64);
  EXPECT_EQ(NumberOf(out[0]), 7U);
  EXPECT_EQ(adapter.Send(Numbered(8)), SendResult::kSent);
  const std::vector<Frame> in = PumpFrames(serial, 1);
  ASSERT_EQ(in.size(), 1U);
  EXPECT_EQ(NumberOf(in[0]), 8U);
}

/// An adapter that is pulled out and plugged in again: another device by the same name.
TEST(SlcanSerial, OpensItsDeviceAgainWhenItComesBack) {
  const std::string link = testing::TempDir() + "adapter" + std::to_string(::getpid());
  auto adapter = std::make_unique<SlcanAdapter>(link);
  SlcanSerial serial(link, BusOptions{});
  PumpUntilState(*adapter, "client connected, channel open");
  adapter.reset();
  while (!serial.IsGone()) serial.Receive();
  EXPECT_EQ(serial.PollFd(), -1);
  EXPECT_EQ(serial.Send(Numbered(1)), SendResult::kDisconnected);
  EXPECT_FALSE(serial.Receive());
  adapter = std::make_unique<SlcanAdapter>(link);
  while (serial.IsGone()) serial.Receive();
  PumpUntilState(*adapter, "client connected, channel open");
  EXPECT_EQ(serial.Send(Numbered(2)), SendResult::kSent);
  EXPECT_EQ(NumberOf(PumpFrames(*adapter, 1).at(0)), 2U) << "and nothing of before";
  EXPECT_EQ(adapter->Send(Numbered(3)), SendResult::kSent);
  EXPECT_EQ(NumberOf(PumpFrames(serial, 1).at(0)), 3U);
}

TEST(SlcanSerial, IsUsedOnlyWherePhysicalBusesAre) {
  BusOptions options;
  options.allow_physical = false;
  EXPECT_THROW(SlcanSerial("/dev/null", options), base::UsageError);
  SlcanAdapter adapter("");
  const SlcanSerial terminal(adapter.Name().substr(6), options);
  EXPECT_TRUE(terminal.IsVirtual());
}

template <typename Error>
std::string ErrorOf(const std::string& device, std::uint32_t bit_rate) {
  BusOptions options;
  options.bit_rate_bit_s = bit_rate;
  try {
    const SlcanSerial bus(device, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(SlcanSerial, SaysWhatIsMissing) {
  EXPECT_EQ(
      ErrorOf<base::UsageError>("/dev/null", 333'000),
      "a serial CAN adapter has no code for 333000 bit/s; it knows 10000, 20000, 50000, 100000, 125000, "
      "250000, 500000, 800000, 1000000");
  EXPECT_EQ(
      ErrorOf<base::EnvironmentError>("/dev/ttyNONE", 500'000),
      "cannot open /dev/ttyNONE: No such file or directory: is the adapter plugged in? This lists them: ls "
      "/dev/serial/by-id /dev/ttyACM* /dev/ttyUSB*");
  EXPECT_EQ(ErrorOf<base::EnvironmentError>("/dev/null", 500'000), "/dev/null is not a serial device");
}

}  // namespace
}  // namespace servohil::can
