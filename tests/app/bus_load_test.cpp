#include <gtest/gtest.h>

#include "default_setup.hpp"

namespace servohil::app {
namespace {

TEST(WorstCaseFrameBits, AreThePublishedOnes) {
  // Davis et al. 2007, after eq. (1): 8 data bytes take 135 bits with 11-bit identifiers, 160 with 29-bit
  // ones.
  EXPECT_EQ(WorstCaseFrameBits(8, false), 135);
  EXPECT_EQ(WorstCaseFrameBits(8, true), 160);
  EXPECT_EQ(WorstCaseFrameBits(0, false), 55);
  EXPECT_EQ(WorstCaseFrameBits(0, true), 80);
}

TEST(BusLoad, AddsUpWhatIsSentAndReceived) {
  const testing::DefaultSetup setup({"publish.relay_ms=0", "publish.safety_ms=0"});
  double bits_per_s = 0.0;
  const auto loads = setup.contract.BusLoad(10);
  for (const Contract::Load& load : loads) bits_per_s += load.bits_per_s;
  ASSERT_EQ(loads.size(), 4U) << "command, position, pressures, status";
  // Command 4 bytes: 34 + 32 + 13 + floor(65 / 4) = 95 bits each 10 ms; two of 135 each 10 ms, one each 100
  // ms.
  EXPECT_NEAR(bits_per_s, (95 + 135 + 135) * 100.0 + 135 * 10.0, 1e-9);
}

}  // namespace
}  // namespace servohil::app
