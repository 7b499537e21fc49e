#include "can/slcan/slcan_codec.hpp"

#include <gtest/gtest.h>

#include <string>

namespace servohil::can::slcan {
namespace {

std::string Format(const Frame& frame) {
  return std::string(FormatFrame(frame, std::nullopt).View());
}
std::optional<Frame> Parse(std::string_view line) {
  return ParseFrame(line, Timestamp::kRefused);
}

TEST(SlcanCodec, WorkedLines) {
  Frame frame;
  frame.id = 0x12B;
  frame.size = 2;
  frame.data = {0xF4, 0x01};
  EXPECT_EQ(Format(frame), "t12B2F401\r");
  frame.extended = true;
  EXPECT_EQ(Format(frame), "T0000012B2F401\r");
  frame.fd = true;
  EXPECT_EQ(Format(frame), "D0000012B2F401\r");
  frame.bit_rate_switch = true;
  EXPECT_EQ(Format(frame), "B0000012B2F401\r");
  frame.extended = false;
  EXPECT_EQ(Format(frame), "b12B2F401\r");
  EXPECT_EQ(FormatFrame(frame, 0xEA5F).View(), "b12B2F401EA5F\r");
}

TEST(SlcanCodec, RemoteFramesHaveALengthAndNoData) {
  Frame frame;
  frame.id = 0x7FF;
  frame.remote = true;
  frame.size = 8;
  EXPECT_EQ(Format(frame), "r7FF8\r");
  const auto parsed = Parse("r7FF8");
  ASSERT_TRUE(parsed);
  EXPECT_TRUE(parsed->remote);
  EXPECT_EQ(parsed->size, 8);
}

TEST(SlcanCodec, FdSizesGoUpToTheNextCode) {
  Frame frame;
  frame.fd = true;
  frame.size = 10;
  frame.data.fill(0xAA);
  EXPECT_EQ(Format(frame), "d0009AAAAAAAAAAAAAAAAAAAA0000\r");  // 12 bytes, the last two zero
  frame.size = 64;
  EXPECT_EQ(Format(frame).size(), 1U + 3 + 1 + 128 + 1);
}

TEST(SlcanCodec, RefusesWhatIsNotExactlyAFrame) {
  for (const char* line : {"",         "t",       "t1",        "t12",     "t123",  "t1231",      "t12311",
                           "t1231112", "t1239",   "t8000",     "t123811", "tg230", "T200000000", "T0000012",
                           "r7FF9",    "r7FF811", "d12391122", "x1230",   "t 230", "t+230",      "t0x10"}) {
    EXPECT_FALSE(Parse(line)) << line;
  }
  EXPECT_TRUE(Parse("t12311a"));
  EXPECT_TRUE(Parse("T1FFFFFFF0"));
}

TEST(SlcanCodec, TimestampsOnlyWhereTheyBelongAndBelowOneMinute) {
  EXPECT_FALSE(ParseFrame("t1230EA5F", Timestamp::kRefused));
  EXPECT_TRUE(ParseFrame("t1230EA5F", Timestamp::kAllowed));  // 59999 ms
  EXPECT_FALSE(ParseFrame("t1230EA60", Timestamp::kAllowed));
  EXPECT_FALSE(ParseFrame("t1230EA5", Timestamp::kAllowed));
  EXPECT_FALSE(ParseFrame("t1230EA5F0", Timestamp::kAllowed));
}

}  // namespace
}  // namespace servohil::can::slcan
