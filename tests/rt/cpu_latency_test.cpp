#include "rt/cpu_latency.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace servohil::rt {
namespace {

/// The kernel's interface (Documentation/power/pm_qos_interface.rst): a 32-bit number of µs, written as
/// bytes.
TEST(CpuLatencyHold, WritesZeroMicrosecondsToTheDevice) {
  const std::filesystem::path device = std::filesystem::path(::testing::TempDir()) / "cpu_dma_latency";
  std::ofstream(device).put('x');
  {
    const CpuLatencyHold hold(device.c_str());
    EXPECT_EQ(hold.Missing(), Shortcomings{});
  }
  std::ifstream in(device, std::ios::binary);
  const std::string written((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  EXPECT_EQ(written, std::string(4, '\0'));
  std::filesystem::remove(device);
}

TEST(CpuLatencyHold, SaysWhatIsMissingAndTheCommandThatMendsIt) {
  const CpuLatencyHold hold("/nowhere/cpu_dma_latency");
  ASSERT_EQ(hold.Missing().size(), 1U);
  EXPECT_EQ(
      hold.Missing().front(),
      "CPUs may enter deep idle states, /nowhere/cpu_dma_latency (No such file or directory): sudo chmod "
      "o+rw /nowhere/cpu_dma_latency");
}

}  // namespace
}  // namespace servohil::rt
