#include "can/socketcan/link.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdio>
#include <latch>
#include <sstream>
#include <string>
#include <thread>

#include "base/error.hpp"

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

/// What `ask` returns; the test fails if anything is printed meanwhile.
template <typename Ask>
auto Silently(Ask ask) {
  ::testing::internal::CaptureStderr();
  const auto answer = ask();
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  return answer;
}

// libsocketcan prints "RTNETLINK answers: ..." and its like.
TEST(Controller, WhatCannotBeDoneIsSilentlyRefused) {
  for (const char* name : {"nosuch0", "lo"}) {
    EXPECT_FALSE(Silently([&] { return ReadController(name).has_value(); })) << name;
    EXPECT_FALSE(Silently([&] { return SetBitTiming(name, 500'000, 0.875); })) << name;
    EXPECT_FALSE(Silently([&] { return SetRestartMs(name, 100); })) << name;
    EXPECT_FALSE(Silently([&] { return Restart(name); })) << name;
  }
  EXPECT_FALSE(Silently([] { return can::SetUp("nosuch0", true); }));
}

TEST(Controller, OtherOutputGoesOnMeanwhile) {
  ::testing::internal::CaptureStderr();
  std::FILE* const shown = stderr;
  std::atomic<bool> done{false};
  std::latch begun{1};
  std::thread log([&] {
    std::fputs("line\n", shown);
    for (begun.count_down(); !done;) std::fputs("line\n", shown);
  });
  begun.wait();
  for (int i = 0; i < 100; ++i) ReadController("nosuch0");
  done = true;
  log.join();
  EXPECT_EQ(stderr, shown);
  std::fflush(stderr);
  const std::string text = ::testing::internal::GetCapturedStderr();
  EXPECT_FALSE(text.empty());
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) ASSERT_EQ(line, "line");
}

TEST(Link, OfAnInterfaceThatIsNotThereIsRefusedInOneLine) {
  const std::string refusal = Silently([] {
    try {
      ConfigureLink("nosuch0", {});
    } catch (const base::EnvironmentError& error) {
      return std::string(error.what());
    }
    return std::string();
  });
  EXPECT_EQ(refusal.rfind("can.configure: ", 0), 0U) << refusal;
  EXPECT_NE(refusal.find("nosuch0"), std::string::npos) << refusal;
  EXPECT_EQ(refusal.find('\n'), std::string::npos) << refusal;
}

}  // namespace
}  // namespace servohil::can
