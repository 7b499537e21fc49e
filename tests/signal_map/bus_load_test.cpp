#include <gtest/gtest.h>

#include "support/default_setup.hpp"

namespace servohil::signal_map {
namespace {

TEST(BusLoad, AddsUpWhatIsSentAndReceived) {
  const testing::DefaultSetup setup({"publish.relay_ms=0", "publish.safety_ms=0", "publish.bus_ms=0"});
  double bits_per_s = 0.0;
  const auto loads = setup.signal_map.BusLoad();
  for (const SignalMap::Load& load : loads) bits_per_s += load.bits_per_s;
  ASSERT_EQ(loads.size(), 4U) << "command, position, pressures, status";
  // Command 4 bytes: 34 + 32 + 13 + floor(65 / 4) = 95 bits each 10 ms; two of 135 each 10 ms, one each 100
  // ms.
  EXPECT_NEAR(bits_per_s, (95 + 135 + 135) * 100.0 + 135 * 10.0, 1e-9);
}

}  // namespace
}  // namespace servohil::signal_map
