#include "can/slcan/slcan_outbox.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cstdio>

#include "terminal.hpp"

namespace servohil::can::slcan {
namespace {

/// A frame line whose data are its number.
std::string LineOf(unsigned number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "t1004%08X\r", number);
  return text.data();
}

/// A client that stops reading, an outbox, and a clock that only the test moves.
class OutboxTest {
 public:
  Outbox::Outcome WriteNext() {
    const Outbox::Outcome outcome = outbox_.Write(LineOf(next_++), now_);
    accepted_ += outcome.written ? 1 : 0;
    lost_ += outcome.lost_frames;
    return outcome;
  }
  /// Writes numbered lines until the terminal stays full: polling lets the kernel move what it can, once.
  void Fill() {
    while (WriteNext().written) continue;
    WaitReadable(client_.Fd(), 1000);
    while (WriteNext().written) continue;
  }
  void Wait(std::chrono::milliseconds time) { now_ += time; }
  void TakeBack() { lost_ += outbox_.TakeBack(); }
  /// Writes a line that is no frame. @return it
  std::string Answer() {
    const bool written = answered_ || outbox_.Write("V0101\r", now_).written;
    EXPECT_TRUE(written);
    answered_ = true;
    return "V0101\r";
  }
  std::string Read(std::size_t most) {
    WaitReadable(client_.Fd(), 1000);
    return client_.Read(most);
  }
  std::string ReadUntil(const std::string& end) { return client_.ReadUntil(end); }
  std::string Newest() const { return LineOf(next_ - 1); }
  std::uint64_t Accepted() const { return accepted_; }
  std::uint64_t Lost() const { return lost_; }

 private:
  Pty pty_;
  Client client_{pty_.SlavePath()};
  Outbox outbox_{pty_};
  Outbox::TimePoint now_{};
  unsigned next_ = 0;
  bool answered_ = false;
  std::uint64_t accepted_ = 0;
  std::uint64_t lost_ = 0;
};

TEST(SlcanOutbox, RefusesNewLinesForHalfASecondThenTakesBackTheOldOnes) {
  OutboxTest test;
  test.Fill();
  const std::uint64_t accepted = test.Accepted();
  test.Wait(Outbox::kStalled - std::chrono::milliseconds(1));
  EXPECT_FALSE(test.WriteNext().written);
  test.Wait(std::chrono::milliseconds(1));
  const Outbox::Outcome outcome = test.WriteNext();
  EXPECT_TRUE(outcome.written);
  EXPECT_EQ(outcome.lost_frames, accepted);
  EXPECT_EQ(test.ReadUntil("\r"), test.Newest());
}

TEST(SlcanOutbox, AClientThatReadsAtAllLosesNothingThatWasAccepted) {
  OutboxTest test;
  test.Fill();
  std::string text;
  while (text.size() < 8192) text += test.Read(4096);
  EXPECT_TRUE(test.WriteNext().written);
  test.Wait(Outbox::kStalled);
  EXPECT_TRUE(test.WriteNext().written);
  text += test.ReadUntil(test.Newest());
  EXPECT_EQ(text.size(), test.Accepted() * test.Newest().size());
  EXPECT_EQ(test.Lost(), 0U);
}

TEST(SlcanOutbox, CountsLinesThatAreAllTheSame) {
  const Pty pty;
  const Client client(pty.SlavePath());
  Outbox outbox(pty);
  std::uint64_t accepted = 0;
  while (outbox.Write("t1230\r", {}).written) ++accepted;
  const std::string read = client.ReadUntil("t1230\rt1230\rt12");
  EXPECT_EQ(outbox.TakeBack(), accepted - 3);
  EXPECT_TRUE(outbox.Write("z\r", {}).written);
  EXPECT_EQ(read + client.ReadUntil("z\r"), "t1230\rt1230\rt1230\rz\r");
}

RC_GTEST_PROP(SlcanOutbox, LinesStayWholeWhereverTheClientStopsAndHoweverOften, ()) {
  OutboxTest test;
  std::string text;
  for (int round = 0; round < 3; ++round) {
    test.Fill();
    text += test.Read(*rc::gen::inRange<std::size_t>(1, 100));
    test.Wait(Outbox::kStalled);
    test.WriteNext();
  }
  test.TakeBack();
  text += test.ReadUntil(test.Answer());
  text.erase(text.size() - test.Answer().size());
  const std::size_t size = LineOf(0).size();
  std::string last;
  for (std::size_t at = 0; at < text.size(); at += size) {
    const std::string line = text.substr(at, size);
    RC_ASSERT(line.substr(0, 5) == "t1004");
    RC_ASSERT(line.find('\r') == size - 1);
    RC_ASSERT(line > last);
    last = line;
  }
  RC_ASSERT(text.size() / size + test.Lost() == test.Accepted());
}

}  // namespace
}  // namespace servohil::can::slcan
