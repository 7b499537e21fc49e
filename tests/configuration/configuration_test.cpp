#include "configuration/configuration.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <sstream>

#include "base/error.hpp"
#include "support/default_setup.hpp"

namespace servohil::configuration {
namespace {

using testing::kConfigurationFile;

std::string ReadText(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

/// The one line that loading gives for wrong settings.
std::string ErrorOf(const std::vector<std::string>& settings,
                    const std::string& file = testing::kConfigurationFile) {
  try {
    LoadConfiguration(file, settings);
  } catch (const base::UsageError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Configuration, TheShippedFileHoldsEveryKeyWithItsDefault) {
  Configuration defaults;
  Configuration shipped = LoadConfiguration(testing::kConfigurationFile, {});
  const std::string text = ReadText(testing::kConfigurationFile);
  for (const Key& key : KeyTable()) {
    const std::string name = key.name;
    const std::string leaf = name.substr(name.rfind('.') + 1);
    EXPECT_NE(text.find("\n" + leaf + " = "), std::string::npos)
        << name << " is missing in config/servohil.toml";
    if (name == "load.file" || name == "can.dbc") continue;  // resolved to where the file lies
    std::visit([&](auto place) { EXPECT_EQ(place(defaults), place(shipped)) << name; }, key.place);
  }
}

TEST(Configuration, SettingsWinInTheirOrder) {
  const Configuration c =
      LoadConfiguration(testing::kConfigurationFile,
                        {"servo.underlap_in=0.001", "servo.underlap_in=.0015", "cam.shape=two_slope",
                         "stabilizer.enabled=true", "can.buses=[\"slcan:pty\",\"slcan:pty:/tmp/x\"]"});
  EXPECT_DOUBLE_EQ(c.model.servo.underlap_in, 0.0015);
  EXPECT_EQ(c.model.cam.shape, model::CamShape::kTwoSlope);
  EXPECT_TRUE(c.model.stabilizer.enabled);
  EXPECT_EQ(c.can.buses.size(), 2U);
}

TEST(Configuration, AMistakeIsOneLineWhateverTheValueHolds) {
  EXPECT_EQ(ErrorOf({"a\n\x1B[2Jb=1"}),
            "--set a  [2Jb=1: unknown key a  [2Jb; `servohil run --help-keys` lists all");
}

TEST(Configuration, MistakesNamePlaceKeyValueAndWhatIsRight) {
  EXPECT_EQ(ErrorOf({"servo.underlap_in=3"}),
            "--set servo.underlap_in=3: servo.underlap_in = 3: must be a number from -0.05 to 0.05 in");
  EXPECT_EQ(ErrorOf({"servo.underlap=0.001"}),
            "--set servo.underlap=0.001: unknown key servo.underlap; did you mean servo.underlap_in?");
  EXPECT_EQ(ErrorOf({"stabilizer.enabled=1"}),
            "--set stabilizer.enabled=1: stabilizer.enabled = 1: must be true or false");
  EXPECT_EQ(ErrorOf({"loop.wake_ticks=2.5"}),
            "--set loop.wake_ticks=2.5: loop.wake_ticks = 2.5: must be a whole number from 1 to 1000 ticks");
  EXPECT_EQ(ErrorOf({"servo.underlap_in=nan"}),
            "--set servo.underlap_in=nan: servo.underlap_in = nan: must be a number from -0.05 to 0.05 in");
  EXPECT_EQ(ErrorOf({"cam.shape=round"}),
            "--set cam.shape=round: cam.shape = 'round': must be \"single\" or \"two_slope\"");
  EXPECT_EQ(ErrorOf({"novalue"}), "--set novalue: expected KEY=VALUE");
  EXPECT_EQ(ErrorOf({"loop.wake_ticks=100", "publish.position_ms=5"}),
            "--set publish.position_ms=5: publish.position_ms = 5: must be 0 or at least the wake period, "
            "loop.wake_ticks = 100 ticks of 0.1 ms");
}

TEST(Configuration, MistakesInAFileNameItsLine) {
  const std::string file = ::testing::TempDir() + "wrong.toml";
  std::ofstream(file) << "[servo]\nunderlap_in = 0.001\n\n[suply]\npressure_psi = 200.0\n";
  EXPECT_EQ(ErrorOf({}, file),
            file + ":5: unknown key suply.pressure_psi; did you mean supply.pressure_psi?");
  std::ofstream(file) << "[servo]\nunderlap_in = = 2\n";
  EXPECT_EQ(ErrorOf({}, file).rfind(file + ":2: ", 0), 0U) << ErrorOf({}, file);
  std::remove(file.c_str());
  EXPECT_EQ(ErrorOf({}, file).rfind(file, 0), 0U) << ErrorOf({}, file);
}

/// The line as it stands, and what would be right.
TEST(Configuration, WhatIsNoTomlLeadsOn) {
  const auto error = [](const std::string& text) -> std::string {
    try {
      ParseConfiguration(text, "x.toml", {});
    } catch (const base::UsageError& mistake) {
      return mistake.what();
    }
    return "no error";
  };
  EXPECT_EQ(error("[can.command]\r\n  p1 = GOV.P1\r\n"),
            "x.toml:2: p1 = GOV.P1: could not determine value type: a text stands in quotes");
  EXPECT_EQ(error("[can.command]\npgn = True"),
            "x.toml:2: pgn = True: expected 'true', saw 'T': true and false are written in small letters");
  const std::vector<std::pair<std::string, std::string>> others = {
      {"dbc = [\"C:\\Users\\me\\x.dbc\"]", ": a backslash begins an escape: write / or 'single quotes'"},
      {"dbc = [\"C:\\dbc\\x.dbc\"]", ": a backslash begins an escape: write / or 'single quotes'"},
      {"[can.publish]\n[can.publish]",
       ": each table stands once; lists of tables have double brackets: [[can.publish]]"},
      {"name = \"a\nb = 1", ": is a closing quote missing?"},
      {"a = 1 # \xB0", ": save the file as UTF-8"}};
  for (const auto& [text, end] : others) {
    const std::string said = error(text);
    EXPECT_EQ(said.substr(0, 7), "x.toml:") << said;
    ASSERT_GE(said.size(), end.size()) << said;
    EXPECT_EQ(said.substr(said.size() - end.size()), end) << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
}

TEST(Configuration, TheLoadTableIsChecked) {
  const std::string file = ::testing::TempDir() + "load.csv";
  const auto error_for = [&](const std::string& text) {
    std::ofstream(file) << text;
    return ErrorOf({"load.file=\"" + file + "\""});
  };
  EXPECT_EQ(error_for("x3_in,p3_psi\n1,60\n"), file + ": 1 rows, expected 2 to 254");
  EXPECT_EQ(error_for("x3_in,p3_psi\n1,60\n1,70\n"),
            file + ":3: x3_in must rise from row to row; this one is not above the one before");
  EXPECT_EQ(error_for("x3_in,p3_psi\n1,60\n2,abc\n"), file + ":3: \"abc\" is not a number");
  EXPECT_EQ(error_for("x3_in,p3_psi\n1,60,3\n"), file + ":2: 3 fields, expected 2 (x3_in,p3_psi)");
  EXPECT_EQ(error_for("x,p\n"), file + ":1: header is \"x,p\", expected \"x3_in,p3_psi\"");
  EXPECT_EQ(error_for("x3_in,p3_psi\n1,60\n2,70\n"), "no error");
}

}  // namespace
}  // namespace servohil::configuration
