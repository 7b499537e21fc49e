#include "signal_map/signal_map.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "can/dbc/codec.hpp"
#include "support/default_setup.hpp"
#include "support/paths.hpp"
#include "support/signal_map_files.hpp"

namespace servohil::signal_map {
namespace {

/// Nothing published.
configuration::Configuration QuietConfiguration() {
  return configuration::LoadConfiguration(
      testing::kConfigurationFile, {"publish.position_ms=0", "publish.pressures_ms=0", "publish.relay_ms=0",
                                    "publish.bus_ms=0", "publish.safety_ms=0", "publish.status_ms=0"});
}

std::string ErrorOf(const std::string& dbc) {
  try {
    const SignalMap signal_map({{can::ParseDbc(dbc, "test.dbc")}}, QuietConfiguration());
  } catch (const base::UsageError& error) {
    return error.what();
  }
  return "no error";
}

TEST(SignalMap, EncodesAWorkedFrame) {
  const testing::DefaultSetup setup;
  simulation::RunState t;
  t.sample.tick = 0x01020304;
  t.sample.state.x3_in = 4.0;
  t.sample.state.v3_in_s = -1.5;
  const can::Frame frame = setup.signal_map.Encode(testing::kPosition, t);
  EXPECT_EQ(frame.id, 0x200U);
  EXPECT_FALSE(frame.extended);
  ASSERT_EQ(frame.size, 8);
  // X3: (4.0 + 1) / 0.0002 = 25000 = 0x61A8; V3: -1.5 / 0.01 = -150 = 0xFF6A; Tick as it is; all Intel.
  const std::array<std::uint8_t, 8> expected = {0xA8, 0x61, 0x6A, 0xFF, 0x04, 0x03, 0x02, 0x01};
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(frame.data[i], expected[i]) << "byte " << i;
}

TEST(SignalMap, DecodesAWorkedCommand) {
  const testing::DefaultSetup setup;
  can::Frame frame;
  frame.id = 0x100;
  frame.size = 4;
  // P1 30.533 psi = 30533 raw = 0x07745 in bits 12 to 31; counter 3 in bits 8 to 11.
  frame.data = {0x00, 0x53, 0x74, 0x07};
  CommandRejection rejection{};
  const auto command = setup.signal_map.Decode(frame, rejection);
  ASSERT_TRUE(command);
  EXPECT_NEAR(command->p1_psi.value_or(0.0), 30.533, 1e-12);
}

TEST(SignalMap, TellsApartWhyAFrameIsNoCommand) {
  const testing::DefaultSetup setup;
  can::Frame frame;
  frame.id = 0x100;
  frame.size = 4;
  CommandRejection rejection{};
  can::Frame other = frame;
  other.id = 0x101;
  EXPECT_FALSE(setup.signal_map.Decode(other, rejection));
  EXPECT_EQ(rejection, CommandRejection::kUnknownId);
  other = frame;
  other.extended = true;
  EXPECT_FALSE(setup.signal_map.Decode(other, rejection));
  EXPECT_EQ(rejection, CommandRejection::kUnknownId) << "0x100 with 29 bits is another identifier";
  other = frame;
  other.size = 3;
  EXPECT_FALSE(setup.signal_map.Decode(other, rejection));
  EXPECT_EQ(rejection, CommandRejection::kMalformed);
  other = frame;
  other.remote = true;
  EXPECT_FALSE(setup.signal_map.Decode(other, rejection));
  EXPECT_EQ(rejection, CommandRejection::kMalformed);
  other = frame;
  other.data = {0, 0xF0, 0xFF, 0xFF};  // 1048.575 psi
  EXPECT_FALSE(setup.signal_map.Decode(other, rejection));
  EXPECT_EQ(rejection, CommandRejection::kOutOfRange);
}

TEST(SignalMap, HasTheResolutionThatWasPromised) {
  const can::Database dbc = can::ReadDbc(testing::ConfigFile("servohil.dbc"));
  for (const can::Message& message : dbc.messages) {
    for (const can::Signal& signal : message.signals) {
      if (signal.unit == "in") {
        EXPECT_LE(signal.factor, 0.0005) << signal.name;
      }
      if (signal.unit == "psi") {
        EXPECT_LE(signal.factor, 0.01) << signal.name;
      }
    }
  }
}

TEST(SignalMap, RefusesADbcThatDoesNotFit) {
  EXPECT_NE(ErrorOf("BO_ 1 GOV_Comand: 8 X\n").find("GOV_Command"), std::string::npos);
  EXPECT_NE(ErrorOf("BO_ 1 GOV_Command: 8 X\n SG_ P1_Demand : 0|16@1+ (1,0) [0|0] \"V\" X\n")
                .find("test.dbc:2: GOV_Command.P1_Demand has the unit \"V\", expected one of psi, bar"),
            std::string::npos);
  EXPECT_NE(ErrorOf("BO_ 1 GOV_Command: 8 X\n SG_ P1 : 0|16@1+ (1,0) [0|0] \"psi\" X\n").find("P1_Demand"),
            std::string::npos);
  EXPECT_EQ(ErrorOf("BO_ 1 GOV_Command: 8 X\n SG_ P1_Demand : 0|16@1+ (1,0) [0|0] \"psi\" X\n"), "no error");
}

using testing::SignalMapFiles;
constexpr double kPsiPerBar = 1e5 / 6894.757293168;

can::Frame FrameOf(std::uint32_t id, bool extended, std::initializer_list<std::uint8_t> bytes) {
  can::Frame frame;
  frame.id = id;
  frame.extended = extended;
  frame.size = static_cast<std::uint8_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  return frame;
}

std::vector<int> BytesOf(const can::Frame& frame) {
  return {frame.data.begin(), frame.data.begin() + frame.size};
}

TEST(SignalMap, P1IsConvertedFromItsUnit) {
  const std::string dbc = "BO_ 1 GOV: 3 X\n SG_ P1 : 15|16@0+ (0.001,0) [0|0] \"bar\" X\n";
  CommandRejection why{};
  const can::Frame frame = FrameOf(1, false, {0, 0x08, 0x00});  // 2.048 bar
  const auto bar = SignalMapFiles("[can.command]\np1 = \"GOV.P1\"\n" + testing::kNothingPublished, {dbc})
                       .Bind()
                       .Decode(frame, why);
  EXPECT_NEAR(*bar->p1_psi, 2.048 * kPsiPerBar, 1e-11);
  EXPECT_EQ(why, CommandRejection::kNone);
  const auto kpa = SignalMapFiles("[can.command]\np1 = \"GOV.P1\"\nunit = \"kPa\"\nmay_clip = true\n" +
                                      testing::kNothingPublished,
                                  {dbc})
                       .Bind()
                       .Decode(frame, why);
  EXPECT_NEAR(*kpa->p1_psi, 0.02048 * kPsiPerBar, 1e-9);
}

TEST(SignalMap, P1IsScaledFromCurrent) {
  const SignalMapFiles files(
      "[can.command]\np1 = \"GOV.Loop\"\nscale = [[4.0, 0.0], [20.0, 150.0]]\n" + testing::kNothingPublished,
      {"BO_ 1 GOV: 4 X\n SG_ Loop : 0|32@1- (1,0) [3.6|21] \"mA\" X\nSIG_VALTYPE_ 1 Loop : 1;\n"});
  const SignalMap signal_map = files.Bind();
  CommandRejection why{};
  EXPECT_EQ(signal_map.Decode(FrameOf(1, false, {0, 0, 0x40, 0x41}), why)->p1_psi, 75.0);  // 12 mA
  EXPECT_FALSE(signal_map.Decode(FrameOf(1, false, {0, 0, 0, 0x40}), why));  // 2 mA: broken wire
  EXPECT_EQ(why, CommandRejection::kOutOfRange);
  EXPECT_FALSE(signal_map.Decode(FrameOf(1, false, {0, 0, 0xC0, 0x7F}), why));  // not a number
  EXPECT_EQ(why, CommandRejection::kOutOfRange);
}

TEST(SignalMap, EnableAndTripComeFromAnyMessageAndHold) {
  const SignalMap signal_map =
      SignalMapFiles(
          "[can.command]\np1 = \"GOV.P1\"\nenable = \"GOV.On\"\ntrip = \"MODE.State = Tripped\"\n" +
              testing::kNothingPublished,
          {"BO_ 1 GOV: 3 X\n SG_ P1 : 0|16@1+ (0.01,0) [0|500] \"psi\" X\n SG_ On : 16|1@1+ (1,0) [0|1] "
           "\"\" X\nBO_ 2 MODE: 1 X\n SG_ State : 0|4@1+ (1,0) [0|15] \"\" X\nVAL_ 2 State 4 \"Tripped\" "
           ";\n"})
          .Bind();
  ASSERT_EQ(signal_map.IncomingMessages().size(), 2U);
  EXPECT_EQ(signal_map.Wanted().size(), 2U);
  simulation::Command command;
  CommandRejection why{};
  Merge(*signal_map.Decode(FrameOf(1, false, {0xE8, 3, 0}), why), command);  // 10 psi, not enabled
  EXPECT_EQ(command.p1_psi, 10.0);
  EXPECT_FALSE(command.enabled);
  EXPECT_FALSE(command.trip);
  Merge(*signal_map.Decode(FrameOf(2, false, {4}), why), command);
  EXPECT_TRUE(command.trip);
  Merge(*signal_map.Decode(FrameOf(1, false, {0xD0, 7, 1}), why), command);
  EXPECT_EQ(command.p1_psi, 20.0);
  EXPECT_TRUE(command.enabled);
  EXPECT_TRUE(command.trip) << "MODE has not said otherwise";
  Merge(*signal_map.Decode(FrameOf(2, false, {3}), why), command);
  EXPECT_FALSE(command.trip);
}

TEST(SignalMap, ATripCountsBesideAP1ThatDoesNot) {
  const SignalMap signal_map =
      SignalMapFiles("[can.command]\np1 = \"GOV.P1\"\ntrip = \"GOV.Trip\"\n" + testing::kNothingPublished,
                     {"BO_ 1 GOV: 3 X\n SG_ P1 : 0|16@1+ (0.01,0) [0|500] \"psi\" X\n SG_ Trip : "
                      "16|1@1+ (1,0) [0|1] \"\" X\n"})
          .Bind();
  CommandRejection why{};
  const auto demand = signal_map.Decode(FrameOf(1, false, {0xFF, 0xFF, 1}), why);
  ASSERT_TRUE(demand);
  EXPECT_EQ(why, CommandRejection::kOutOfRange);
  EXPECT_FALSE(demand->p1_psi);
  EXPECT_EQ(demand->trip, true);
}

// 41 x 0.1 is 4.1000000000000005 in doubles: the valve closed at full demand.
TEST(SignalMap, P1AtTheEndsOfItsStatedRangeCounts) {
  CommandRejection why{};
  const SignalMap signal_map =
      SignalMapFiles("[can.command]\np1 = \"GOV.P1\"\n" + testing::kNothingPublished,
                     {"BO_ 1 GOV: 2 X\n SG_ P1 : 0|16@1+ (0.1,0) [0|4.1] \"bar\" X\n"})
          .Bind();
  EXPECT_TRUE(signal_map.Decode(FrameOf(1, false, {41, 0}), why));
  EXPECT_TRUE(signal_map.Decode(FrameOf(1, false, {0, 0}), why));
  EXPECT_FALSE(signal_map.Decode(FrameOf(1, false, {42, 0}), why));
  EXPECT_EQ(why, CommandRejection::kOutOfRange);
}

TEST(SignalMap, P1TellsHowFarItMayBeFromWhatWasMeant) {
  CommandRejection why{};
  const SignalMap signal_map =
      SignalMapFiles("[can.command]\np1 = \"GOV.P1\"\nscale = [[10.0, 0.0], [100.0, 300.0]]\n" +
                         testing::kNothingPublished,
                     {"BO_ 1 GOV: 2 X\n SG_ P1 : 0|16@1+ (0.5,0) [0|100] \"%\" X\n"})
          .Bind();
  const auto full = signal_map.Decode(FrameOf(1, false, {200, 0}), why);
  ASSERT_TRUE(full && full->p1_psi);
  EXPECT_NEAR(full->p1_rounding_psi, 0.25 * 300.0 / 90.0, 1e-12);  // half of 0.5 %
  EXPECT_NEAR(*full->p1_psi, 300.0, 1e-12);
}

// A governor of 50 ms was lost after 30 ms, for ever.
TEST(SignalMap, TheCommandsCycleIsTheDbcsWhereTheKeyIsNotGiven) {
  const auto bind = [](const std::string& keys, const std::string& attributes) {
    return SignalMapFiles("[can.command]\np1 = \"GOV.P1\"\n" + keys + testing::kNothingPublished,
                          {"BO_ 1 GOV: 2 X\n SG_ P1 : 0|16@1+ (0.01,0) [0|500] \"psi\" X\n" + attributes})
        .Bind();
  };
  const std::string fifty =
      "BA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 65535;\nBA_ \"GenMsgCycleTime\" BO_ 1 50;\n";
  const SignalMap stated = bind("", fifty);
  EXPECT_EQ(stated.CommandCycleMs(), 50);
  EXPECT_NE(stated.IncomingMessages().front().cycle_from.find("x.dbc:1, GenMsgCycleTime"), std::string::npos);
  EXPECT_EQ(stated.CycleMismatch(), "");
  EXPECT_EQ(bind("", "").CommandCycleMs(), 10);
  EXPECT_EQ(bind("cycle_ms = 20\n", "").CommandCycleMs(), 20);
  EXPECT_EQ(bind("cycle_ms = 20\n", "").CycleMismatch(), "");
  const SignalMap both = bind("cycle_ms = 20\n", fifty);
  EXPECT_EQ(both.CommandCycleMs(), 20);
  EXPECT_NE(both.CycleMismatch().find("can.command.cycle_ms = 20, but "), std::string::npos);
  EXPECT_NE(
      both.CycleMismatch().find("x.dbc:1: GOV has GenMsgCycleTime 50; leave the key out to follow the DBC"),
      std::string::npos);
}

SignalMap WithTrip(const std::string& trip, const std::string& values) {
  return SignalMapFiles(
             "[can.command]\np1 = \"GOV.P1\"\ntrip = \"" + trip + "\"\n" + testing::kNothingPublished,
             {"BO_ 1 GOV: 4 X\n SG_ P1 : 0|16@1+ (0.01,0) [0|500] \"psi\" X\n SG_ Trip : 16|1@1- (1,0) [0|1] "
              "\"\" X\n SG_ State : 17|4@1+ (1,0) [0|15] \"\" X\n" +
              values})
      .Bind();
}

bool Trips(const SignalMap& signal_map, std::uint8_t byte) {
  CommandRejection why{};
  return signal_map.Decode(FrameOf(1, false, {0, 0, byte, 0}), why)->trip.value();
}

TEST(SignalMap, ANamedTripIsComparedByItsBits) {
  const SignalMap one_bit = WithTrip("GOV.Trip = tripped", "VAL_ 1 Trip 0 \"normal\" 1 \"tripped\" ;\n");
  EXPECT_TRUE(Trips(one_bit, 0b1));
  EXPECT_FALSE(Trips(one_bit, 0b0));
  const SignalMap by_number = WithTrip("GOV.Trip = 1", "");
  EXPECT_TRUE(Trips(by_number, 0b1));
  EXPECT_FALSE(Trips(by_number, 0b0));
}

TEST(SignalMap, ANameOfSeveralValuesIsAnyOfThem) {
  const SignalMap signal_map =
      WithTrip("GOV.State = tripped", "VAL_ 1 State 0 \"run\" 2 \"tripped\" 3 \"tripped\" ;\n");
  EXPECT_TRUE(Trips(signal_map, 2 << 1));
  EXPECT_TRUE(Trips(signal_map, 3 << 1));
  EXPECT_FALSE(Trips(signal_map, 0));
  EXPECT_FALSE(Trips(signal_map, 1 << 1));
}

TEST(SignalMap, ANameThatNeverMatchesOrIsAmbiguousIsRefused) {
  const auto error = [](const std::string& trip, const std::string& values) -> std::string {
    try {
      WithTrip(trip, values);
    } catch (const base::UsageError& refused) {
      return refused.what();
    }
    return "accepted";
  };
  EXPECT_NE(error("GOV.State = tripped", "VAL_ 1 State 0 \"run\" 16 \"tripped\" ;\n")
                .find("has 4 bits and is never \"tripped\" (16)"),
            std::string::npos);
  EXPECT_NE(error("GOV.Trip = tripped", "VAL_ 1 Trip 1 \"tripped\" -1 \"normal\" ;\n")
                .find("\"tripped\" and \"normal\" are the same bits (-1); a raw number will do"),
            std::string::npos);
}

// FF opened the valve, enable 3 was enabled.
TEST(SignalMap, WhatJ1939CallsNotAvailableIsNoValue) {
  const std::string dbc =
      "BO_ 2364540158 VP: 8 GOV\n SG_ P1 : 16|8@1+ (4,0) [0|0] \"kPa\" VDU\n SG_ Enable : 24|2@1+ (1,0) "
      "[0|3] \"\" "
      "VDU\n SG_ Trip : 26|2@1+ (1,0) [0|3] \"\" VDU\nBA_DEF_ BO_ \"VFrameFormat\" ENUM "
      "\"StandardCAN\",\"ExtendedCAN\",\"reserved\",\"J1939PG\";\nBA_ \"VFrameFormat\" BO_ 2364540158 3;\n";
  const auto bind = [&](const std::string& keys) {
    return SignalMapFiles("[can.command]\np1 = \"VP.P1\"\nenable = \"VP.Enable\"\ntrip = \"VP.Trip\"\n" +
                              keys + testing::kNothingPublished,
                          {dbc})
        .Bind();
  };
  const SignalMap signal_map = bind("");
  CommandRejection why{};
  const auto decode = [&](std::uint8_t p1, std::uint8_t conditions) {
    return signal_map.Decode(FrameOf(0x0CF0'04FE, true, {0xFF, 0xFF, p1, conditions, 0xFF, 0xFF, 0xFF, 0xFF}),
                             why);
  };
  const auto good = decode(0x34, 0b0001);
  EXPECT_EQ(why, CommandRejection::kNone);
  EXPECT_TRUE(*good->enabled);
  EXPECT_FALSE(*good->trip);
  const auto none = decode(0xFF, 0b1111);
  EXPECT_EQ(why, CommandRejection::kNotAvailable);
  EXPECT_FALSE(none->p1_psi);
  EXPECT_EQ(none->enabled, false);
  EXPECT_FALSE(none->trip) << "says nothing of a trip";
  EXPECT_FALSE(decode(0xFE, 0b1010)->p1_psi);
  EXPECT_EQ(why, CommandRejection::kErrorIndicator);
  EXPECT_FALSE(decode(0xFB, 0b0001)->p1_psi);
  EXPECT_EQ(why, CommandRejection::kOutOfRange);
  EXPECT_TRUE(decode(0xFA, 0b0001)->p1_psi);
  EXPECT_TRUE(*decode(0x34, 0b0101)->trip);
}

TEST(SignalMap, AMultiplexedP1CountsWhileItIsThere) {
  const SignalMap signal_map =
      SignalMapFiles("[can.command]\np1 = \"GOV.P1\"\n" + testing::kNothingPublished,
                     {"BO_ 1 GOV: 3 X\n SG_ Page M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ P1 m2 : "
                      "8|16@1+ (0.01,0) [0|500] \"psi\" X\n"})
          .Bind();
  CommandRejection why{};
  EXPECT_EQ(signal_map.Decode(FrameOf(1, false, {2, 0xE8, 3}), why)->p1_psi, 10.0);
  EXPECT_FALSE(signal_map.Decode(FrameOf(1, false, {1, 0xE8, 3}), why));
  EXPECT_EQ(why, CommandRejection::kUnknownId);
}

TEST(SignalMap, AParameterGroupCountsFromAnySource) {
  const std::string dbc =
      "BO_ 2365530401 GOV: 2 X\n SG_ P1 : 0|16@1+ (0.01,0) [0|500] \"psi\" X\n";  // 0x0CFF2121
  CommandRejection why{};
  const SignalMap any =
      SignalMapFiles("[can.command]\np1 = \"GOV.P1\"\npgn = true\n" + testing::kNothingPublished, {dbc})
          .Bind();
  EXPECT_TRUE(any.Decode(FrameOf(0x18FF'2133, true, {0, 0}), why));
  EXPECT_FALSE(any.Decode(FrameOf(0x18FF'2233, true, {0, 0}), why));
  EXPECT_EQ(any.Wanted()[0].mask, 0x03FF'FF00U);
  const SignalMap one =
      SignalMapFiles("[can.command]\np1 = \"GOV.P1\"\n" + testing::kNothingPublished, {dbc}).Bind();
  EXPECT_FALSE(one.Decode(FrameOf(0x18FF'2133, true, {0, 0}), why));
  EXPECT_TRUE(one.Decode(FrameOf(0x0CFF'2121, true, {0, 0}), why));
}

/// A governor of servohil's own, and these messages published.
SignalMap Publishing(const std::string& toml, const std::string& dbc) {
  return SignalMapFiles("[can.command]\np1 = \"GOV.P1\"\n" + toml,
                        {"BO_ 1 GOV: 2 X\n SG_ P1 : 0|16@1+ (0.01,0) [0|500] \"psi\" X\n" + dbc})
      .Bind();
}

TEST(SignalMap, QuantitiesAreConvertedAndScaled) {
  const SignalMap signal_map = Publishing(
      "[[can.publish]]\nmessage = \"FB\"\ncycle_ms = 20\nsignals = { Mm = \"x3_in\", Ma = { quantity = "
      "\"x3_in\", scale = "
      "[[0.0, 4.0], [8.0, 20.0]] }, Kpa = { quantity = \"p3_psi\", unit = \"kPa\" } }\n",
      "BO_ 2 FB: 8 X\n SG_ Mm : 7|16@0+ (0.01,0) [0|0] \"mm\" X\n SG_ Ma : 16|16@1+ (0.001,0) [0|25] \"mA\" "
      "X\n SG_ Kpa : "
      "39|32@0- (1,0) [0|0] \"\" X\nSIG_VALTYPE_ 2 Kpa : 1;\n");
  simulation::RunState t;
  t.sample.state.x3_in = 4.0;
  t.sample.state.p3_psi = 100.0;
  const can::Frame frame = signal_map.Encode(0, t);
  EXPECT_EQ(signal_map.CycleTicks(0), 200U);
  // 101.6 mm = 10160 = 0x27B0, Motorola; 12 mA = 12000 = 0x2EE0, Intel; 689.4757 kPa = 0x442C5E72 as float.
  EXPECT_EQ(BytesOf(frame), (std::vector<int>{0x27, 0xB0, 0xE0, 0x2E, 0x44, 0x2C, 0x5E, 0x72}));
}

TEST(SignalMap, WhatIsNotMappedHasItsStartValueOrItsConstant) {
  const SignalMap signal_map = Publishing(
      "[[can.publish]]\nmessage = \"FB\"\nsignals = { Wide = { raw = 9007199254740993 }, Half = 1.5 }\n",
      "BO_ 2 FB: 12 X\n SG_ Wide : 0|64@1+ (1,0) [0|0] \"\" X\n SG_ Half : 64|8@1+ (0.5,0) [0|0] \"\" X\n "
      "SG_ Start : "
      "72|8@1+ (1,0) [0|100] \"\" X\nBA_DEF_ SG_ \"GenSigStartValue\" INT 0 255;\nBA_DEF_ BO_ "
      "\"GenMsgCycleTime\" INT 0 "
      "10000;\nBA_DEF_DEF_ \"GenMsgCycleTime\" 50;\nBA_ \"GenSigStartValue\" SG_ 2 Start 255;\n");
  EXPECT_EQ(signal_map.CycleTicks(0), 500U) << "GenMsgCycleTime";
  // 2^53 + 1 comes through: it never is a double.
  EXPECT_EQ(BytesOf(signal_map.Encode(0, {})), (std::vector<int>{1, 0, 0, 0, 0, 0, 0x20, 0, 3, 0xFF, 0, 0}));
}

TEST(SignalMap, FdMessagesHaveTheirFormat) {
  const std::string dbc =
      "BO_ 2 FB: 24 X\n SG_ X : 128|16@1+ (0.01,0) [0|0] \"mm\" X\nBA_DEF_ BO_ \"VFrameFormat\" ENUM "
      "\"StandardCAN\",\"StandardCAN_FD\";\nBA_DEF_ BO_ \"CANFD_BRS\" ENUM \"0\",\"1\";\nBA_DEF_DEF_ "
      "\"CANFD_BRS\" "
      "\"1\";\nBA_ \"VFrameFormat\" BO_ 2 1;\n";
  const SignalMap signal_map =
      Publishing("[[can.publish]]\nmessage = \"FB\"\ncycle_ms = 10\nsignals = { X = \"x3_in\" }\n", dbc);
  simulation::RunState t;
  t.sample.state.x3_in = 1.0;
  const can::Frame frame = signal_map.Encode(0, t);
  EXPECT_TRUE(frame.fd);
  EXPECT_TRUE(frame.bit_rate_switch);
  EXPECT_TRUE(signal_map.UsesFd());
  EXPECT_FALSE(
      SignalMap(configuration::LoadConfiguration(testing::ConfigFile("servohil.toml"), {})).UsesFd());
  EXPECT_EQ(frame.size, 24);
  EXPECT_EQ(frame.data[16] | frame.data[17] << 8, 2540);
  // Command of 2 bytes: 34 + 16 + 13 + floor(49 / 4) = 75 bits each 10 ms. 24 bytes FD: 34 bits, and at four
  // times the rate 5 + 192 + (53 - 4) + 32 = 278.
  const auto loads = signal_map.BusLoad();
  EXPECT_NEAR(loads[0].bits_per_s, 7500.0, 1e-9);
  EXPECT_NEAR(loads[1].bits_per_s, (34 + 278 / 4.0) * 100.0, 1e-9);
}

TEST(SignalMap, PagesOfAMultiplexedMessageComeInTurn) {
  const SignalMap signal_map = Publishing(
      "[[can.publish]]\nmessage = \"FB\"\ncycle_ms = 10\nsignals = { A = \"active_faults\", B = { raw = 7 }, "
      "All = \"mode\" "
      "}\n",
      "BO_ 2 FB: 3 X\n SG_ Page M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ A m3 : 8|8@1+ (1,0) [0|0] \"\" X\n SG_ B "
      "m5 : 8|8@1+ "
      "(1,0) [0|0] \"\" X\n SG_ C m6 : 8|8@1+ (1,0) [0|0] \"\" X\n SG_ All : 16|8@1+ (1,0) [0|0] \"\" X\n");
  simulation::RunState t;
  t.status.active_faults = 2;
  t.status.mode = simulation::Mode::kRunning;
  EXPECT_EQ(BytesOf(signal_map.Encode(0, t, {}, 0)), (std::vector<int>{3, 2, 1}));
  EXPECT_EQ(BytesOf(signal_map.Encode(0, t, {}, 1)), (std::vector<int>{5, 7, 1}));
  EXPECT_EQ(BytesOf(signal_map.Encode(0, t, {}, 2)), (std::vector<int>{3, 2, 1}))
      << "nothing is mapped to page 6";
}

TEST(SignalMap, SaturationOfWhatIsMeasuredIsTold) {
  const SignalMap signal_map = Publishing(
      "[[can.publish]]\nmessage = \"FB\"\ncycle_ms = 10\nsignals = { Late = \"late_ticks\", P3 = \"p3_psi\", "
      "X3 = \"x3_in\" "
      "}\n",
      "BO_ 2 FB: 4 X\n SG_ X3 : 0|16@1+ (0.001,0) [0|8] \"in\" X\n SG_ P3 : 16|8@1+ (1,0) [0|0] \"psi\" X\n "
      "SG_ Late : "
      "24|4@1+ (1,0) [0|0] \"\" X\n");
  simulation::RunState t;
  t.status.late.woke_late = 100;  // saturates by design
  FieldSet saturated = 0;
  signal_map.Encode(0, t, {}, 0, &saturated);
  EXPECT_EQ(saturated, 0U);
  t.sample.state.p3_psi = 256.0;
  signal_map.Encode(0, t, {}, 0, &saturated);
  EXPECT_EQ(saturated, 0b010U) << "by number, in the order of the file: X3, P3, Late";
  t.sample.state.x3_in = 8.01;
  signal_map.Encode(0, t, {}, 0, &saturated);
  EXPECT_EQ(saturated, 0b011U);
}

TEST(SignalMap, TheExampleOfAForeignGovernorIsSound) {
  const SignalMap signal_map(
      configuration::LoadConfiguration(testing::ConfigFile("examples/foreign/servohil.toml"), {}));
  EXPECT_EQ(signal_map.MessageCount(), 3U);
  EXPECT_EQ(signal_map.MessagesCarrying("x3_in"), simulation::SetOf(0));
  EXPECT_EQ(signal_map.MessagesCarrying("command_age_ms"), simulation::SetOf(2));
  // J1939: bits of no signal are ones.
  EXPECT_EQ(signal_map.Encode(0, {}).data[7], 0xFF);
}

TEST(SignalMap, TheProtocolNamesEveryQuantity) {
  std::ifstream in(testing::ConfigFile("../PROTOCOL.md"));
  const std::string protocol{std::istreambuf_iterator<char>(in), {}};
  for (const simulation::Quantity& quantity : simulation::Quantities()) {
    const std::string row = "| `" + std::string(quantity.name) + "` | `" + quantity.signal + "` |";
    EXPECT_NE(protocol.find(row), std::string::npos) << row;
  }
}

}  // namespace
}  // namespace servohil::signal_map
