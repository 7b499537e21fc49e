/// Each mistake in DBC files and mapping, with the line that it is answered with.

#include <gtest/gtest.h>

#include "support/signal_map_files.hpp"

namespace servohil::signal_map {
namespace {

const std::string kDbc =
    "BO_ 1 GOV: 8 X\n"                                    // line 1
    " SG_ P1 : 0|16@1+ (0.001,0) [0|0] \"bar\" X\n"       // 2: 0 to 65.535 bar
    " SG_ Demand : 16|16@1+ (0.001,0) [0|25] \"mA\" X\n"  // 3
    " SG_ State : 32|4@1+ (1,0) [0|0] \"\" X\n"           // 4
    " SG_ Narrow : 40|8@1+ (0.01,0) [0|0] \"bar\" X\n"    // 5: 0 to 2.55 bar, 37 psi
    "BO_ 2 FB: 8 Y\n"                                     // 6
    " SG_ Page M : 0|4@1+ (1,0) [0|0] \"\" X\n"           // 7
    " SG_ Lift m0 : 8|16@1+ (0.01,0) [0|0] \"mm\" X\n"    // 8
    " SG_ Percent m1 : 8|8@1+ (0.5,0) [0|100] \"%\" X\n"  // 9
    " SG_ Short m2 : 8|8@1+ (0.5,0) [0|0] \"mm\" X\n"     // 10: 127.5 mm, the stroke is 203
    "BO_ 3 TEXT: 1 Y\n"                                   // 11
    "VAL_ 1 State 3 \"Tripped\" 1 \"Running\" ;\n";
const std::string kCommand = "[can.command]\np1 = \"GOV.P1\"\n";  // lines 6, 7

std::string CommandError(const std::string& command) {
  return testing::SignalMapFiles("[can.command]\n" + command + testing::kNothingPublished, {kDbc}).Error();
}

/// [[can.publish]] is line 8.
std::string PublishError(const std::string& publish) {
  return testing::SignalMapFiles(kCommand + "[[can.publish]]\n" + publish, {kDbc}).Error();
}

/// The text begins with these words.
#define EXPECT_PREFIX(text, prefix) EXPECT_EQ((text).substr(0, std::string(prefix).size()), prefix)

TEST(SignalMapMistakes, TheExampleItselfHasNone) {
  EXPECT_EQ(CommandError("p1 = \"GOV.P1\"\nenable = \"GOV.State = Running\"\ntrip = \"GOV.State=3\"\n"),
            "no error");
  EXPECT_EQ(PublishError("message = \"FB\"\ncycle_ms = 10\nsignals = { Lift = \"x3_in\" }\n"), "no error");
}

TEST(SignalMapMistakes, UnknownNamesAreAnsweredWithTheNearest) {
  EXPECT_EQ(CommandError("p1 = \"GOVE.P1\"\n"),
            "x.toml:7: can.command.p1 = \"GOVE.P1\": x.dbc: no message 'GOVE'; the nearest is 'GOV'");
  EXPECT_EQ(CommandError("p1 = \"GOV.Deman\"\n"),
            "x.toml:7: can.command.p1 = \"GOV.Deman\": x.dbc:1: message 'GOV' has no signal 'Deman'; the "
            "nearest is "
            "'Demand'");
  EXPECT_EQ(CommandError("p1 = \"P1\"\n"), "x.toml:7: can.command.p1 = \"P1\": must be \"MESSAGE.SIGNAL\"");
  EXPECT_EQ(CommandError("p1 = \"GOV.P1\"\ntrip = \"GOV.State = Triped\"\n"),
            "x.toml:8: can.command.trip = \"GOV.State = Triped\": x.dbc:4: GOV.State has no value \"Triped\" "
            "in its "
            "VAL_; the nearest is \"Tripped\"");
  EXPECT_EQ(CommandError("p1 = \"GOV.P1\"\ntrip = \"GOV.State = 16\"\n"),
            "x.toml:8: can.command.trip = \"GOV.State = 16\": x.dbc:4: GOV.State has 4 bits and is never 16");
  EXPECT_EQ(PublishError("message = \"FBB\"\n"), "x.toml:8: x.dbc: no message 'FBB'; the nearest is 'FB'");
  EXPECT_EQ(PublishError("mesage = \"FB\"\n"), "x.toml:8: can.publish: `message` is missing");
  EXPECT_EQ(PublishError("message = \"FB\"\ncycle_m = 10\n"),
            "x.toml:10: unknown key can.publish.cycle_m; did you mean cycle_ms?");
  EXPECT_EQ(PublishError("message = \"FB\"\ncycle_ms = 10\nsignals = { Lft = \"x3_in\" }\n"),
            "x.toml:11: x.dbc:6: message 'FB' has no signal 'Lft'; the nearest is 'Lift'");
  EXPECT_EQ(PublishError("message = \"FB\"\ncycle_ms = 10\nsignals = { Lift = \"x3_mm\" }\n"),
            "x.toml:11: FB.Lift = \"x3_mm\" is no quantity of the emulator; did you mean x3_in?");
  EXPECT_EQ(
      PublishError(
          "message = \"FB\"\ncycle_ms = 10\nsignals = { Lift = { quantity = \"x3_in\", unt = \"mm\" } }\n"),
      "x.toml:11: unknown key FB.Lift.unt; did you mean unit?");
}

TEST(SignalMapMistakes, UnitsThatDoNotFit) {
  EXPECT_EQ(
      CommandError("p1 = \"GOV.Demand\"\n"),
      "x.toml:7: can.command.p1 = \"GOV.Demand\": x.dbc:3: GOV.Demand has the unit \"mA\", expected one of "
      "psi, bar, mbar, Pa, hPa, kPa, MPa, kgf/cm2, psia, bara, kPaa; else give `unit` where that is "
      "what it "
      "means, or `scale = [[x, y], [x, y]]`");
  EXPECT_PREFIX(CommandError("p1 = \"GOV.P1\"\nunit = \"Bra\"\n"),
                "x.toml:7: can.command.p1 = \"GOV.P1\": x.dbc:2: GOV.P1: the unit \"Bra\" is not kn");
  EXPECT_EQ(CommandError("p1 = \"GOV.P1\"\nunit = \"bar\"\nscale = [[4, 0], [20, 150]]\n"),
            "x.toml:7: can.command.p1 = \"GOV.P1\": give can.command.unit or can.command.scale, not both");
  EXPECT_EQ(CommandError("p1 = \"GOV.Demand\"\nscale = [[4, 0], [4, 150]]\n"),
            "x.toml:8: can.command.scale: must be two different points, as [[4.0, 0.0], [20.0, 150.0]]");
  EXPECT_EQ(
      CommandError("p1 = \"GOV.Demand\"\nscale = [4, 0, 20, 150]\n"),
      "x.toml:8: can.command.scale = [ 4, 0, 20, 150 ]: must be two points, as [[4.0, 0.0], [20.0, 150.0]]");
  EXPECT_EQ(PublishError("message = \"FB\"\ncycle_ms = 10\nsignals = { Percent = \"x3_in\" }\n"),
            "x.toml:11: x.dbc:9: FB.Percent has the unit \"%\", expected one of in, mm, cm, m, um; "
            "else give "
            "`unit` where that is what it means, or `scale = [[x, y], [x, y]]`");
}

TEST(SignalMapMistakes, RangesThatClip) {
  EXPECT_PREFIX(
      CommandError("p1 = \"GOV.Narrow\"\n"),
      "x.toml:7: can.command.p1 = \"GOV.Narrow\": x.dbc:5: GOV.Narrow reaches from 0 to 36.9846 psi; the st");
  EXPECT_EQ(CommandError("p1 = \"GOV.Narrow\"\nmay_clip = true\n"), "no error");
  EXPECT_PREFIX(CommandError("p1 = \"GOV.Demand\"\nscale = [[4, 0], [20, 30]]\n"),
                "x.toml:7: can.command.p1 = \"GOV.Demand\": x.dbc:3: GOV.Demand reaches fro");
  EXPECT_EQ(PublishError("message = \"FB\"\ncycle_ms = 10\nsignals = { Short = \"x3_in\" }\n"),
            "x.toml:11: x.dbc:10: FB.Short holds 0 to 127.5 mm; the stroke of 0 to 8 in is 0 to 203.2: "
            "correct unit or "
            "scale, or set may_clip = true in `signals`");
  EXPECT_EQ(PublishError("message = \"FB\"\ncycle_ms = 10\nsignals = { Short = { quantity = \"x3_in\", "
                         "may_clip = true } }\n"),
            "no error");
}

TEST(SignalMapMistakes, ConstantsThatDoNotFit) {
  EXPECT_EQ(PublishError("message = \"FB\"\ncycle_ms = 10\nsignals = { Percent = 101.0 }\n"),
            "x.toml:11: x.dbc:9: FB.Percent = 101: must be 0 to 100");
  EXPECT_EQ(PublishError("message = \"FB\"\ncycle_ms = 10\nsignals = { Percent = { raw = 256 } }\n"),
            "x.toml:11: x.dbc:9: FB.Percent has 8 bits and cannot hold raw = 256");
  EXPECT_EQ(PublishError("message = \"FB\"\ncycle_ms = 10\nsignals = { Page = 1 }\n"),
            "x.toml:11: x.dbc:7: FB.Page is the multiplexer: it is sent with each of its values in turn");
  EXPECT_EQ(PublishError("message = \"FB\"\ncycle_ms = 10\nsignals = { Percent = true }\n"),
            "x.toml:11: FB.Percent = true: must be a quantity in quotes, a number, or { quantity = ..., unit "
            "= ... }");
}

TEST(SignalMapMistakes, CycleTimes) {
  EXPECT_EQ(PublishError("message = \"TEXT\"\n"),
            "x.toml:8: x.dbc:11: TEXT has no cycle time (GenMsgCycleTime): give cycle_ms");
  EXPECT_EQ(PublishError("message = \"TEXT\"\ncycle_ms = 0\n"),
            "x.toml:10: can.publish.cycle_ms = 0: must be a whole number from 1 to 10000 ms");
  EXPECT_EQ(
      PublishError("message = \"TEXT\"\ncycle_ms = 1\n[loop]\nwake_ticks = 20\n"),
      "x.toml:8: TEXT: cycle_ms = 1: must be at least the wake period, loop.wake_ticks = 20 ticks of 0.1 ms");
}

TEST(SignalMapMistakes, FilesThatCannotBeRead) {
  const std::string utf16("\xFF\xFE\x42\x00\x4F\x00", 6);
  EXPECT_EQ(testing::SignalMapFiles(kCommand + testing::kNothingPublished, {utf16}).Error(),
            "x.dbc: is UTF-16, expected UTF-8 or Windows-1252: save it as one of these");
  const testing::SignalMapFiles files(kCommand + testing::kNothingPublished, {kDbc});
  configuration::Configuration configuration = files.Load();
  configuration.can.dbc.front().insert(configuration.can.dbc.front().size() - 4, "x");
  try {
    const SignalMap signal_map(configuration);
    ADD_FAILURE();
  } catch (const base::UsageError& error) {
    const std::string said = error.what();
    EXPECT_NE(said.find("x.toml:4: can.dbc: "), std::string::npos) << said;
    const std::string end = "xx.dbc: there is no such file; there is x.dbc";
    EXPECT_EQ(said.substr(said.size() - end.size()), end);
  }
}

TEST(SignalMapMistakes, WhatIsLeftOut) {
  const std::string there = "; there are 3: GOV FB TEXT";
  EXPECT_EQ(
      testing::SignalMapFiles(testing::kNothingPublished, {kDbc}).Error(),
      "can.command.p1 is not set, and \"GOV_Command.P1_Demand\" in its place will not do: x.dbc: no message "
      "'GOV_Command'" +
          there);
  EXPECT_EQ(testing::SignalMapFiles(kCommand, {kDbc}).Error(),
            "no [[can.publish]]: x.dbc: no message 'SERVO_Position'" + there);
}

TEST(SignalMapMistakes, Protection) {
  EXPECT_EQ(
      PublishError("message = \"FB\"\ncycle_ms = 10\ne2e = \"crc8_j1850\"\ncounter = \"Lifd\"\n"),
      "x.toml:8: counter = \"Lifd\": x.dbc:6: message 'FB' has no signal 'Lifd'; the nearest is 'Lift'");
}

TEST(SignalMapMistakes, IdentifiersThatMeet) {
  EXPECT_EQ(PublishError("message = \"GOV\"\ncycle_ms = 10\nsignals = { State = 1 }\n"),
            "x.toml:8: GOV (x.dbc:1) is named twice in the configuration: both received and published, or "
            "published twice");
  EXPECT_EQ(
      PublishError("message = \"TEXT\"\ncycle_ms = 10\n[[can.publish]]\nmessage = \"TEXT\"\ncycle_ms = 20\n"),
      "x.toml:11: TEXT (x.dbc:11) is named twice in the configuration: both received and published, or "
      "published twice");
  const std::string twin = "BO_ 1 OTHER: 8 X\n";
  EXPECT_EQ(testing::SignalMapFiles(kCommand + testing::kNothingPublished, {kDbc, twin}).Error(),
            "x.toml:7: can.command.p1 = \"GOV.P1\": y.dbc:1: message 'OTHER' has the id of 'GOV' in x.dbc:1: "
            "leave one "
            "of the two files out");
  EXPECT_EQ(CommandError("p1 = \"GOV.P1\"\npgn = true\n"),
            "x.toml:7: can.command.p1 = \"GOV.P1\": x.dbc:1: message 'GOV' has an 11-bit identifier, "
            "can.command.pgn = "
            "true is for J1939's 29-bit ones");
  // 0x0CFF2121 whatever the source: 0x0CFF2133 would be read as it.
  const std::string group =
      "BO_ 2365530401 GOV: 8 X\n SG_ P1 : 0|16@1+ (0.001,0) [0|0] \"bar\" X\nBO_ 2365530419 OWN: 8 X\n";
  EXPECT_EQ(testing::SignalMapFiles(kCommand + "pgn = true\n" + testing::kNothingPublished, {group}).Error(),
            "x.toml:7: can.command.p1 = \"GOV.P1\": x.dbc:3: message 'OWN' has the parameter group of 'GOV', "
            "can.command.pgn = true would read it as that one");
}

TEST(SignalMapMistakes, SignalsByNameMustBeQuantities) {
  EXPECT_PREFIX(PublishError("message = \"FB\"\ncycle_ms = 10\n"),
                "x.toml:8: x.dbc:8: FB.Lift is no quantity of the emulator: say with `signals` what it car");
}

TEST(SignalMapMistakes, TypesOfTheTables) {
  EXPECT_EQ(testing::SignalMapFiles("publish = 3\n", {kDbc}).Error(),
            "x.toml:6: can.publish must be a list of tables: [[can.publish]]");
  EXPECT_EQ(testing::SignalMapFiles("publish = [3]\n", {kDbc}).Error(),
            "x.toml:6: can.publish = 3: must be a table: [[can.publish]]");
  EXPECT_EQ(PublishError("message = \"FB\"\non_change = 1\n"),
            "x.toml:10: can.publish.on_change = 1: must be true or false");
  EXPECT_EQ(PublishError("message = \"FB\"\nsignals = [1]\n"),
            "x.toml:10: can.publish.signals = [ 1 ]: must be a table: { SIGNAL = \"quantity\", ... }");
  EXPECT_EQ(PublishError("message = \"FB\"\nsignals = { Lift = { unit = \"mm\" } }\n"),
            "x.toml:10: FB.Lift must have `quantity`, or `raw` for a constant");
}

}  // namespace
}  // namespace servohil::signal_map
