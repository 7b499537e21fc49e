#include "run/bus_setup.hpp"

#include <gtest/gtest.h>

namespace servohil::run {
namespace {

TEST(LogName, IsOneThatCanUtilsTake) {
  EXPECT_EQ(LogName("socketcan:can0", {}), "can0");
  EXPECT_EQ(LogName("slcan:/dev/pts/3", {}), "pts/3");
  EXPECT_EQ(LogName("slcan:/dev/ttyACM0", {}), "ttyACM0");
  EXPECT_EQ(LogName("slcan:/tmp/can", {}), "/tmp/can");
  EXPECT_EQ(LogName("slcan:/tmp/case-bench-adapter", {}), "e-bench-adapter");
  EXPECT_EQ(LogName("slcan:/dev/serial/by-id/usb-Protofusion_Labs_CANable", {}), "on_Labs_CANable");
  EXPECT_EQ(LogName("slcan:/tmp/a b", {}), "/tmp/a_b");
  EXPECT_EQ(LogName("slcan:/tmp/some/adapter/", {}), "adapter");
  EXPECT_EQ(LogName("slcan:/tmp/x/adapter-of-bench", {}), "dapter-of-bench");
}

TEST(LogName, IsNobodyElses) {
  std::vector<std::string> names;
  for (int i = 0; i < 12; ++i) names.push_back(LogName("slcan:/tmp/case-bench-adapter", names));
  EXPECT_EQ(names[1], "e-bench-adapt~2");
  EXPECT_EQ(names[11], "e-bench-adap~12");
  EXPECT_EQ(names[11].size(), 15U);
}

}  // namespace
}  // namespace servohil::run
