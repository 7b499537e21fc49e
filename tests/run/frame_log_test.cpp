#include "run/frame_log.hpp"

#include <gtest/gtest.h>

namespace servohil::run {
namespace {

using V = simulation::FrameVerdict;
constexpr std::int64_t kMs = 1'000'000;

TEST(FrameLog, SaysNothingOfValidFrames) {
  FrameLog log;
  simulation::FrameCounts counts;
  for (int ms = 0; ms < 10'000; ms += 100) {
    counts.Of(V::kValid) += 10;
    EXPECT_EQ(log.Look(counts, ms * kMs), "");
  }
  EXPECT_EQ(log.Rest(counts), "");
}

TEST(FrameLog, TellsTheFirstAtOnceAndWhatFollowsTogether) {
  FrameLog log;
  simulation::FrameCounts counts;
  counts.Of(V::kValid) = 100;
  counts.Of(V::kCorrupted) = 1;
  EXPECT_EQ(log.Look(counts, 5 * kMs), "command frames refused: 1 corrupted");
  counts.Of(V::kCorrupted) = 3;
  counts.Of(V::kOutOfRange) = 1;
  EXPECT_EQ(log.Look(counts, 1004 * kMs), "") << "within a second";
  counts.lost = 2;
  EXPECT_EQ(log.Look(counts, 1005 * kMs),
            "command frames refused: 1 out of range, 2 corrupted; 2 never came");
  counts.lost = 5;
  EXPECT_EQ(log.Look(counts, 3004 * kMs), "") << "within two seconds";
  EXPECT_EQ(log.Rest(counts), "command frames: 3 never came");
  EXPECT_EQ(log.Look(counts, 3005 * kMs), "command frames: 3 never came");
}

/// A governor that is wrong for a day: a line each ten minutes, not each cycle.
TEST(FrameLog, GoesOnEverMoreRarely) {
  FrameLog log;
  simulation::FrameCounts counts;
  int lines = 0;
  constexpr int kDayMs = 86'400'000;
  for (int ms = 0; ms < kDayMs; ms += 1000) {
    counts.Of(V::kCorrupted) += 100;
    if (!log.Look(counts, ms * kMs).empty()) ++lines;
  }
  // 1, 2, 4 ... 512 s are 1023 s; then each 600 s.
  EXPECT_EQ(lines, 1 + 10 + (86'400 - 1024) / 600);
  EXPECT_NE(log.Look(counts, (kDayMs + 600'000) * kMs), "") << "the rest of it";
  EXPECT_EQ(log.Look(counts, (kDayMs + 1'200'000) * kMs), "") << "over";
  ++counts.Of(V::kCorrupted);
  EXPECT_NE(log.Look(counts, (kDayMs + 1'200'001) * kMs), "") << "new: at once";
}

TEST(FrameLog, AsksWhatMayBeWrongWhereMoreAreRefusedThanValid) {
  simulation::FrameCounts counts;
  counts.Of(V::kValid) = 1;
  counts.Of(V::kStuck) = 1;
  EXPECT_EQ(FrameLog().Look(counts, 0), "command frames refused: 1 stuck");
  counts.Of(V::kStuck) = 2;
  EXPECT_EQ(FrameLog().Look(counts, 0),
            "command frames refused: 2 stuck; is can.command.counter the signal that counts, and does it?");
  for (const V verdict :
       {V::kMalformed, V::kOutOfRange, V::kTooFast, V::kCorrupted, V::kRepeated, V::kReordered, V::kJumped}) {
    simulation::FrameCounts only;
    only.Of(verdict) = 1;
    EXPECT_EQ(FrameLog().Look(only, 0).back(), '?') << simulation::NameOf(verdict);
  }
}

}  // namespace
}  // namespace servohil::run
