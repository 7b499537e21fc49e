#include "can/socketcan/link.hpp"

#include <gtest/gtest.h>

namespace servohil::can {
namespace {

std::string Mismatch(std::uint32_t told_bit_s, double told_sample_point, const LinkSettings& wanted) {
  return BitTimingMismatch(
      "can0", {.bit_rate_bit_s = told_bit_s, .sample_point = told_sample_point, .clock_hz = 8'000'000},
      wanted);
}

TEST(Link, ABitTimingMayDifferByALittle) {
  EXPECT_EQ(Mismatch(500'000, 0.875, {}), "");
  EXPECT_EQ(Mismatch(83'333, 0.875, {.bit_rate_bit_s = 83'000}), "");  // 0.4 %
  EXPECT_NE(Mismatch(83'333, 0.875, {.bit_rate_bit_s = 82'900}), "");  // 0.52 %
  EXPECT_EQ(Mismatch(500'000, 0.85, {.sample_point = 0.875}), "");     // what CiA 301 allows
  EXPECT_NE(Mismatch(500'000, 0.849, {.sample_point = 0.875}), "");
  EXPECT_EQ(Mismatch(500'000, 0.6, {.sample_point = 0.0}), "");  // the kernel's choice
}

TEST(Link, WhatADriverDoesNotTellIsNotCompared) {
  EXPECT_EQ(Mismatch(0, 0.0, {}), "");
}

TEST(Link, ABitTimingThatIsOutOfReachIsNamedWithTheNearest) {
  EXPECT_EQ(Mismatch(615'384, 0.846, {.bit_rate_bit_s = 600'000}),
            "can.bit_rate_bit_s = 600000: the nearest that the controller of can0 can do is 615384 (its "
            "clock: 8000000 Hz)");
  EXPECT_EQ(Mismatch(1'000'000, 0.75, {.bit_rate_bit_s = 1'000'000, .sample_point = 0.8}),
            "can.sample_point = 0.800: the nearest that the controller of can0 can do at 1000000 bit/s is "
            "0.750 (its clock: 8000000 Hz); set that if it suits the other nodes");
}

}  // namespace
}  // namespace servohil::can
