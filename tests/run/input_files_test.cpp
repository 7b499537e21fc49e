// Files that a user hands over: mistakes that the fuzzers of tests/fuzz have found in their readers.

#include <gtest/gtest.h>

#include <fstream>

#include "base/error.hpp"
#include "run/candump.hpp"
#include "run/p1_script.hpp"
#include "run/snapshot_file.hpp"
#include "support/scratch.hpp"

namespace servohil::run {
namespace {

/// What reading `text` as a file gives: its error without the file's name, or "no error".
template <typename Read>
std::string ErrorOf(const std::string& text, Read&& read) {
  const testing::Scratch scratch;
  const std::filesystem::path file = scratch / "input";
  std::ofstream(file) << text;
  try {
    read(file);
  } catch (const base::UsageError& error) {
    return std::string(error.what()).substr(file.string().size());
  }
  return "no error";
}

TEST(Candump, TimesAreThoseThatNanosecondsHold) {
  const auto first_time_ns = [](const std::string& line) {
    std::int64_t time_ns = -1;
    ErrorOf(line, [&](const auto& file) { time_ns = ReadCandump(file).at(0).frame.receive_time_ns; });
    return time_ns;
  };
  EXPECT_EQ(first_time_ns("(1436509052.249713) vcan0 044#2A"), 1'436'509'052'249'713'000);
  EXPECT_EQ(first_time_ns("(9223372035.999999999) vcan0 044#2A"), 9'223'372'035'999'999'999);
  EXPECT_EQ(first_time_ns("(9223372036.0) vcan0 044#2A"), -1);  // the last second of 63 bits is not whole
}

TEST(Candump, AStandardIdentifierHas11Bits) {
  EXPECT_EQ(ErrorOf("(1.0) can0 7FF#", ReadCandump), "no error");
  EXPECT_EQ(ErrorOf("(1.0) can0 800#", ReadCandump),
            ":1: \"(1.0) can0 800#\" is no line of a candump log, such as (1436509052.249713) vcan0 "
            "044#2A366C2BBA");
}

TEST(P1Script, TimesAreThoseOfARun) {
  EXPECT_EQ(ErrorOf("t_s,p1_psi\n1e9,60\n", ReadP1Script), "no error");
  EXPECT_EQ(ErrorOf("t_s,p1_psi\n1e15,60\n", ReadP1Script),
            ":2: t_s must be from 0 to 1e9 and rise from row to row");
}

TEST(SnapshotFile, DeepNestingIsDamage) {
  const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
  EXPECT_EQ(ErrorOf("{\"format\": \"servohil snapshot\", \"content\": " + deep + "}", ReadSnapshot),
            ": damaged or no snapshot: it is not JSON");
}

TEST(SnapshotText, WholeNumbersFitWhatHoldsThem) {
  const std::string sound = SnapshotText(emulator::Snapshot{});
  const auto with_tick = [&](const std::string& tick) {
    std::string text = sound;
    const std::string key = "\"tick\":";
    text.replace(text.find(key), key.size() + 1, key + tick);  // it is 0
    return SnapshotText(ParseSnapshotText(text, "x"));
  };
  EXPECT_EQ(with_tick("0"), sound);
  EXPECT_NE(with_tick("18446744073709551615"), sound);
  for (const char* wrong : {"-1", "1e300", "0.5", "true"})
    EXPECT_THROW(with_tick(wrong), base::UsageError) << wrong;
}

TEST(SnapshotText, AFaultWaitsForOneThatThereIs) {
  emulator::Snapshot snapshot;
  fault::Injection injection;
  injection.id = fault::Catalogue()[0].id;
  injection.trigger = {.kind = fault::Trigger::Kind::kFault, .fault = injection.id};
  ASSERT_TRUE(snapshot.faults.Inject(injection));
  EXPECT_NO_THROW(ParseSnapshotText(SnapshotText(snapshot), "x"));
  injection.trigger.fault = 255;
  snapshot.faults = {};
  ASSERT_TRUE(snapshot.faults.Inject(injection));
  EXPECT_THROW(ParseSnapshotText(SnapshotText(snapshot), "x"), base::UsageError);
}

}  // namespace
}  // namespace servohil::run
