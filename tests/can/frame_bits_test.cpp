#include "can/frame_bits.hpp"

#include <gtest/gtest.h>

namespace servohil::can {
namespace {

TEST(FrameBits, OfClassicalFramesAreThePublishedOnes) {
  // Davis et al. 2007, after eq. (1): 8 data bytes take 135 bits with 11-bit identifiers, 160 with 29-bit
  // ones.
  EXPECT_EQ(WorstCaseFrameBits(8, false), 135);
  EXPECT_EQ(WorstCaseFrameBits(8, true), 160);
  EXPECT_EQ(WorstCaseFrameBits(0, false), 55);
  EXPECT_EQ(WorstCaseFrameBits(0, true), 80);
}

TEST(FrameBits, OfTheLongestFdFramesAreThePublishedOnes) {
  // V. Mailhol, "can: length: refactor frame lengths definition", Linux 6.5: 712 and 736 bits with stuffing.
  EXPECT_EQ(WorstCaseFdFrameBits(64, false, false).nominal, 712);
  EXPECT_EQ(WorstCaseFdFrameBits(64, true, false).nominal, 736);
}

TEST(FrameBits, WithBitRateSwitchTheArbitrationStaysSlow) {
  // 17 bits, 4 stuff bits and 13 at the end; the rest of 712 at the second rate.
  EXPECT_EQ(WorstCaseFdFrameBits(64, false, true).nominal, 34);
  EXPECT_EQ(WorstCaseFdFrameBits(64, false, true).data, 712 - 34);
}

TEST(FrameBits, FdFramesArePadded) {
  EXPECT_EQ(WorstCaseFdFrameBits(9, false, true).data, WorstCaseFdFrameBits(12, false, true).data);
  EXPECT_LT(WorstCaseFdFrameBits(8, false, true).data, WorstCaseFdFrameBits(9, false, true).data);
}

TEST(FrameBits, OfAMessageFollowItsFormat) {
  Message message;
  message.size_bytes = 8;
  EXPECT_EQ(WorstCaseBits(message).nominal, 135);
  message.fd = true;
  EXPECT_EQ(WorstCaseBits(message).data, 0);
  message.bit_rate_switch = true;
  EXPECT_GT(WorstCaseBits(message).data, 0);
}

}  // namespace
}  // namespace servohil::can
