#include "can/dbc/id_pattern.hpp"

#include <gtest/gtest.h>

namespace servohil::can {
namespace {

constexpr std::uint32_t kEec1 = 0x0CF0'0400;  // PGN 61444, priority 3, from 0: SAE J1939-71
constexpr std::uint32_t kTsc1 = 0x0C00'1721;  // PGN 0, priority 3, to 0x17 from 0x21
constexpr bool kExtended = true;

TEST(IdPattern, TheParameterGroupIsThePublishedOne) {
  EXPECT_EQ(PgnOf(kEec1), 61444U);
  EXPECT_EQ(PgnOf(0x18FE'F100), 65265U);  // CCVS
  EXPECT_EQ(PgnOf(0x18EA'FF00), 59904U);  // request, to all: the destination is no part of it
  EXPECT_EQ(PgnOf(0x18EB'1700), 60160U);  // TP.DT
  EXPECT_EQ(PgnOf(kTsc1), 0U);
  EXPECT_EQ(PgnOf(0x1DF0'0400), 0x1'F004U);  // data page 1
}

TEST(IdPattern, WithoutPgnEveryBitCounts) {
  const IdPattern pattern{kEec1, kExtended, false};
  EXPECT_TRUE(pattern.Matches(kEec1, kExtended));
  EXPECT_FALSE(pattern.Matches(kEec1 + 1, kExtended));
  EXPECT_FALSE(pattern.Matches(kEec1, !kExtended));
}

TEST(IdPattern, WithPgnSourceAndPriorityDoNotCount) {
  const IdPattern pattern{kEec1, kExtended, true};
  EXPECT_TRUE(pattern.Matches(0x18F0'0433, kExtended));
  EXPECT_FALSE(pattern.Matches(0x0CF0'0500, kExtended));
  EXPECT_FALSE(pattern.Matches(0x0DF0'0400, kExtended)) << "data page 1 is another group";
  EXPECT_FALSE(pattern.Matches(0x18F0'0433, !kExtended));
}

TEST(IdPattern, OfADestinationOnlyWhatIsForItOrForAll) {
  const IdPattern pattern{kTsc1, kExtended, true};
  EXPECT_TRUE(pattern.Matches(0x1800'1755, kExtended));
  EXPECT_TRUE(pattern.Matches(0x1800'FF55, kExtended));
  EXPECT_FALSE(pattern.Matches(0x1800'1855, kExtended));
  const IdPattern open{0x0C00'FE21, kExtended, true};
  EXPECT_TRUE(open.Matches(0x1800'1855, kExtended));
}

TEST(IdPattern, TheKernelFilterPassesAllThatMatches) {
  for (const std::uint32_t id : {kEec1, kTsc1}) {
    const IdPattern pattern{id, kExtended, true};
    const WantedId wanted = pattern.Wanted();
    for (std::uint32_t source = 0; source < 256; ++source) {
      const std::uint32_t other = (id & 0x03FF'FF00U) | 0x1800'0000U | source;
      ASSERT_TRUE(pattern.Matches(other, kExtended));
      EXPECT_EQ(other & wanted.mask, wanted.id & wanted.mask);
    }
  }
  EXPECT_EQ((IdPattern{0x100, false, false}.Wanted().mask), 0x1FFF'FFFFU);
}

TEST(IdPattern, OverlapIsWhereOneFrameWouldBeBoth) {
  EXPECT_TRUE(Overlap({0x100, false, false}, {0x100, false, false}));
  EXPECT_FALSE(Overlap({0x100, false, false}, {0x100, true, false}));
  EXPECT_TRUE(Overlap({kEec1, true, true}, {0x18F0'0477, true, false}));
  EXPECT_TRUE(Overlap({0x18F0'0477, true, false}, {kEec1, true, true}));
  EXPECT_FALSE(Overlap({kEec1, true, true}, {0x18F0'0577, true, true}));
}

}  // namespace
}  // namespace servohil::can
