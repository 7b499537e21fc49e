#include "can/slcan/slcan_adapter.hpp"

#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <sys/stat.h>

#include <atomic>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <latch>
#include <random>
#include <thread>

#include "base/error.hpp"
#include "can/slcan/slcan_codec.hpp"
#include "terminal.hpp"

namespace servohil::can {
namespace {

namespace fs = std::filesystem;

const std::string kOpen = "client connected, channel open";

std::string PathOf(const Bus& bus) {
  return bus.Name().substr(std::string("slcan:").size());
}

/// Opens the channel and waits until the adapter has seen it; the acknowledgement is read.
Client OpenChannel(SlcanAdapter& adapter) {
  Client client(PathOf(adapter));
  client.Write("O\r");
  PumpUntilState(adapter, kOpen);
  EXPECT_EQ(client.ReadUntil("\r"), "\r");
  return client;
}

/// The numbers of all frames in a text; every line must be whole.
std::vector<std::uint32_t> NumbersIn(const std::string& text) {
  std::vector<std::uint32_t> numbers;
  slcan::LineAssembler assembler;
  for (const char byte : text) {
    const auto line = assembler.Push(byte);
    if (!line) continue;
    const auto frame = slcan::ParseFrame(line->text, slcan::Timestamp::kRefused);
    EXPECT_TRUE(frame) << "not a whole line: '" << line->text << "'";
    if (frame) numbers.push_back(NumberOf(*frame));
  }
  return numbers;
}

/// Reads what is on the way until the frame with this number.
std::string ReadUntilNumber(const Client& client, std::uint32_t number) {
  return client.ReadUntil(std::string(slcan::FormatFrame(Numbered(number), std::nullopt).View()));
}

TEST(SlcanAdapter, WithoutClientThereIsNothingToPollAndNothingIsSent) {
  SlcanAdapter adapter("");
  EXPECT_FALSE(adapter.Receive());
  EXPECT_EQ(adapter.PollFd(), -1);
  EXPECT_EQ(adapter.State(), "no client");
  EXPECT_EQ(adapter.Send(Numbered(0)), SendResult::kDisconnected);
  EXPECT_EQ(adapter.Statistics().dropped_disconnected, 1U);
  EXPECT_NE(adapter.ConnectHint().find(PathOf(adapter)), std::string::npos);
}

TEST(SlcanAdapter, FramesGoBothWays) {
  SlcanAdapter adapter("");
  const Client client = OpenChannel(adapter);
  client.Write("t12B2F401\r");
  const std::vector<Frame> frames = PumpFrames(adapter, 1);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].id, 0x12BU);
  EXPECT_EQ(frames[0].data[0], 0xF4);
  EXPECT_GT(frames[0].receive_time_ns, 0);
  EXPECT_EQ(client.ReadUntil("\r"), "z\r");
  EXPECT_EQ(adapter.Send(frames[0]), SendResult::kSent);
  EXPECT_EQ(client.ReadUntil("\r"), "t12B2F401\r");
}

TEST(SlcanAdapter, NothingOldBurstsOutOnOpening) {
  SlcanAdapter adapter("");
  const Client client(PathOf(adapter));
  client.Write("V\r");
  PumpUntilState(adapter, "client connected, channel closed");
  EXPECT_EQ(client.ReadUntil("\r"), "V0101\r");
  for (std::uint32_t i = 0; i < 100; ++i) EXPECT_EQ(adapter.Send(Numbered(i)), SendResult::kDisconnected);
  client.Write("O\r");
  PumpUntilState(adapter, kOpen);
  EXPECT_EQ(adapter.Send(Numbered(100)), SendResult::kSent);
  EXPECT_EQ(ReadUntilNumber(client, 100), "\rt100864000000" + std::string(8, '0') + "\r");
}

TEST(SlcanAdapter, AVanishedClientClosesTheChannelAndLeavesNothingToTheNext) {
  SlcanAdapter adapter("");
  for (int round = 0; round < 20; ++round) {
    {
      const Client client = OpenChannel(adapter);
      client.Write("t1238");  // half a line, cut off by its death
      for (std::uint32_t i = 0; i < 10; ++i) EXPECT_EQ(adapter.Send(Numbered(i)), SendResult::kSent);
    }
    PumpUntilState(adapter, "no client");
    EXPECT_EQ(adapter.PollFd(), -1);
    EXPECT_EQ(adapter.Send(Numbered(11)), SendResult::kDisconnected);
    const Client next = OpenChannel(adapter);  // expects no more than the acknowledgement
    EXPECT_EQ(adapter.Send(Numbered(12)), SendResult::kSent);
    EXPECT_EQ(NumbersIn(ReadUntilNumber(next, 12)), std::vector<std::uint32_t>{12});
    next.Write("C\r");
    PumpUntilState(adapter, "client connected, channel closed");
  }
  EXPECT_EQ(adapter.Statistics().malformed, 0U);
}

TEST(SlcanAdapter, AClientThatHasStoppedReadingFindsFreshLinesAndEveryLossIsCounted) {
  SlcanAdapter adapter("");
  const Client client = OpenChannel(adapter);
  EXPECT_EQ(adapter.Send(Numbered(0)), SendResult::kSent);
  std::string text = client.ReadUntil("t1008");  // stops in the middle of a line
  std::uint32_t frames = 1;
  for (int discards = 0; discards < 2;) {  // each discard loses many frames in one call
    const std::uint64_t before = adapter.Statistics().dropped_queue_full;
    adapter.Send(Numbered(frames++));
    if (adapter.Statistics().dropped_queue_full > before + 1) ++discards;
  }
  text += ReadUntilNumber(client, frames - 1);
  EXPECT_EQ(NumbersIn(text), (std::vector<std::uint32_t>{0, frames - 1}));
  EXPECT_EQ(adapter.Statistics().dropped_queue_full, frames - 2);
  client.Write("F\r");
  Pump(adapter, [received = std::string(), &client](const auto&) mutable {
    received += client.Read();
    return received == "F08\r";
  });
}

TEST(SlcanAdapter, AClosingClientIsAnsweredWithoutOldFrames) {
  SlcanAdapter adapter("");
  const Client client = OpenChannel(adapter);
  for (std::uint32_t i = 0; i < 100; ++i) adapter.Send(Numbered(i));
  client.Write("C\r");
  PumpUntilState(adapter, "client connected, channel closed");
  EXPECT_EQ(client.ReadUntil("\r"), "\r");
  EXPECT_EQ(adapter.Statistics().dropped_queue_full, 100U);
}

TEST(SlcanAdapter, LinesStayWholeUnderTwoWritersAndASlowReader) {
  constexpr std::uint32_t kFrames = 20'000;
  SlcanAdapter adapter("");
  const Client client = OpenChannel(adapter);
  std::atomic<bool> done{false};
  std::thread sender([&] {
    for (std::uint32_t i = 0; i < kFrames; ++i) adapter.Send(Numbered(i));
    done = true;
  });
  std::thread receiver([&] {
    while (!done) {
      if (!adapter.Receive()) WaitReadable(adapter.PollFd());
    }
  });
  std::mt19937 random(1);
  std::string text;
  while (!done) {
    text += client.Read(1 + random() % 300);  // a terminal holds 20 kB or more, the frames are 440 kB
    if (random() % 8 == 0) ::write(client.Fd(), "V\r", 2);
    if (random() % 4 == 0) WaitReadable(adapter.PollFd(), 1);  // lets the sender get ahead
  }
  sender.join();
  receiver.join();
  std::uint32_t frames = kFrames + 1;
  while (adapter.Send(Numbered(kFrames)) != SendResult::kSent) {
    text += client.Read();
    ++frames;
  }
  text += ReadUntilNumber(client, kFrames);

  std::vector<std::uint32_t> numbers;
  slcan::LineAssembler assembler;
  int cut = 0;
  for (const char byte : text) {
    const auto line = assembler.Push(byte);
    if (!line || line->text == "V0101" || line->text.empty()) continue;
    const auto frame = slcan::ParseFrame(line->text, slcan::Timestamp::kRefused);
    cut += frame ? 0 : 1;
    if (frame) numbers.push_back(NumberOf(*frame));
  }
  EXPECT_TRUE(std::is_sorted(numbers.begin(), numbers.end()));
  EXPECT_EQ(cut, 0);
  EXPECT_EQ(numbers.size() + adapter.Statistics().dropped_queue_full, frames);
}

// The end of a run: a client that reads, however slowly, gets the last frame before the terminal closes.
TEST(SlcanAdapter, ASlowReaderGetsTheLastFrames) {
  constexpr std::uint32_t kFrames = 800;
  auto adapter = std::make_unique<SlcanAdapter>("");
  const Client client = OpenChannel(*adapter);
  for (std::uint32_t i = 0; i < kFrames; ++i) ASSERT_EQ(adapter->Send(Numbered(i)), SendResult::kSent);
  std::string read;
  std::thread reader([&] {  // 42 reads, 10 ms apart: longer than what a terminal was kept open for once
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    const std::string last(slcan::FormatFrame(Numbered(kFrames - 1), std::nullopt).View());
    while (read.size() < last.size() || read.substr(read.size() - last.size()) != last) {
      if (std::chrono::steady_clock::now() > deadline) break;
      WaitReadable(-1, 10);
      read += client.Read(400);
    }
  });
  EXPECT_EQ(adapter->Drain(), 0U);
  adapter.reset();
  reader.join();
  const std::vector<std::uint32_t> numbers = NumbersIn(read);
  ASSERT_EQ(numbers.size(), kFrames);
  EXPECT_EQ(numbers.back(), kFrames - 1);
}

// python-can asks how much there is to read before it hands out what it has read: a broken line costs it these frames.
TEST(SlcanAdapter, AClientThatHasReadAllMayLookForMore) {
  auto adapter = std::make_unique<SlcanAdapter>("");
  const Client client = OpenChannel(*adapter);
  ASSERT_EQ(adapter->Send(Numbered(1)), SendResult::kSent);
  std::latch has_read{1};
  int waiting = -1;
  std::thread reader([&] {
    ReadUntilNumber(client, 1);
    has_read.count_down();
    WaitReadable(-1, 20);
    if (::ioctl(client.Fd(), FIONREAD, &waiting) != 0) waiting = -errno;
  });
  has_read.wait();
  adapter.reset();
  reader.join();
  EXPECT_EQ(waiting, 0);
}

TEST(SlcanAdapter, WhatAClientNeverReadsIsCountedAtTheEnd) {
  SlcanAdapter adapter("");
  const Client client = OpenChannel(adapter);
  for (std::uint32_t i = 0; i < 12; ++i) ASSERT_EQ(adapter.Send(Numbered(i)), SendResult::kSent);
  EXPECT_EQ(adapter.Drain(), 12U);
  EXPECT_EQ(adapter.Statistics().dropped_queue_full, 12U);
  EXPECT_EQ(adapter.Drain(), 0U);
}

TEST(SlcanAdapter, AClientThatHasLeftIsNotWaitedFor) {
  SlcanAdapter adapter("");
  {
    const Client client = OpenChannel(adapter);
    ASSERT_EQ(adapter.Send(Numbered(1)), SendResult::kSent);
  }
  EXPECT_EQ(adapter.Drain(), 0U);
}

TEST(SlcanAdapter, TimestampsAreMillisecondsOfAMinute) {
  SlcanAdapter adapter("");
  const Client client(PathOf(adapter));
  client.Write("Z1\rL\r");
  PumpUntilState(adapter, "client connected, listen only");
  adapter.Send(Numbered(0));
  std::string line = client.ReadUntil("\r\r");
  line += client.ReadUntil("\r");
  EXPECT_EQ(line.size(), 2U + 21 + 4 + 1);
  EXPECT_LT(std::stoi(line.substr(23, 4), nullptr, 16), 60'000);
}

TEST(SlcanAdapter, LineNoiseIsRefusedAndCounted) {
  SlcanAdapter adapter("");
  const Client client = OpenChannel(adapter);
  client.Write("\x80\xFF\r" + std::string(500, 'x') + "\rt12\rt1230\r");
  EXPECT_EQ(PumpFrames(adapter, 1).size(), 1U);
  EXPECT_EQ(client.ReadUntil("z\r"), "\a\a\az\r");
  EXPECT_EQ(adapter.Statistics().malformed, 3U);
}

TEST(SlcanAdapter, ATerminalLeftInLineModeIsRawAgainForTheNextClient) {
  SlcanAdapter adapter("");
  {
    const Client client = OpenChannel(adapter);
    termios settings{};
    ASSERT_EQ(::tcgetattr(client.Fd(), &settings), 0);
    settings.c_lflag |= static_cast<tcflag_t>(ICANON) | static_cast<tcflag_t>(ECHO);
    settings.c_iflag |= static_cast<tcflag_t>(ICRNL);
    ASSERT_EQ(::tcsetattr(client.Fd(), TCSANOW, &settings), 0);
  }
  PumpUntilState(adapter, "no client");
  const Client client = OpenChannel(adapter);
  adapter.Send(Numbered(1));
  EXPECT_EQ(NumbersIn(ReadUntilNumber(client, 1)), std::vector<std::uint32_t>{1});
  EXPECT_FALSE(adapter.Receive());  // no echo
  EXPECT_EQ(adapter.Statistics().malformed, 0U);
}

/// A folder of its own, gone afterwards.
class SlcanLink : public testing::Test {
 protected:
  SlcanLink() {
    std::string name = fs::temp_directory_path() / "servohil_link_XXXXXX";
    folder_ = ::mkdtemp(name.data());
  }
  ~SlcanLink() override { fs::remove_all(folder_); }
  std::string Link() const { return folder_ / "governor"; }

  fs::path folder_;
};

TEST_F(SlcanLink, IsThereWhileTheBusIs) {
  {
    SlcanAdapter adapter(Link());
    EXPECT_EQ(adapter.Name(), "slcan:" + Link());
    EXPECT_EQ(fs::read_symlink(Link()).parent_path(), "/dev/pts");
    OpenChannel(adapter);
  }
  EXPECT_FALSE(fs::is_symlink(Link()));
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(SlcanLink, ReplacesAnOldOne) {
  for (const char* old : {"/nowhere/at/all", "/dev/pts/ptmx"}) {
    fs::create_symlink(old, Link());
    const SlcanAdapter adapter(Link());
    EXPECT_NE(fs::read_symlink(Link()), old);
  }
}

TEST_F(SlcanLink, IsLeftAloneWhenItIsAnothersByNow) {
  {
    const SlcanAdapter adapter(Link());
    fs::remove(Link());
    fs::create_symlink("/dev/pts/ptmx", Link());
  }
  EXPECT_EQ(fs::read_symlink(Link()), "/dev/pts/ptmx");
}

TEST_F(SlcanLink, OverwritesNothingElse) {
  std::ofstream(Link()) << "precious";
  EXPECT_THROW(SlcanAdapter{Link()}, base::UsageError);
  EXPECT_EQ(fs::file_size(Link()), 8U);
  fs::remove(Link());
  fs::create_symlink("/etc/passwd", Link());
  EXPECT_THROW(SlcanAdapter{Link()}, base::UsageError);
  EXPECT_THROW(SlcanAdapter{"/nowhere/at/all"}, base::EnvironmentError);
}

}  // namespace
}  // namespace servohil::can
