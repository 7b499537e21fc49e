#include "configuration/configuration_text.hpp"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstdio>
#include <fstream>
#include <random>
#include <type_traits>

#include "base/error.hpp"
#include "recording/recording.hpp"
#include "support/default_setup.hpp"
#include "support/paths.hpp"
#include "support/scratch.hpp"

namespace servohil::configuration {
namespace {

/// Laid out from what a recording would hold, and loaded again.
Configuration Again(const Configuration& configuration, const std::filesystem::path& directory) {
  return LoadConfiguration(WriteConfigurationDirectory(DescribeConfiguration(configuration), directory), {});
}

template <typename T>
bool Same(const T& a, const T& b) {
  if constexpr (std::is_same_v<T, double>)
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
  return a == b;
}

void ExpectSame(Configuration a, Configuration b) {
  for (const Key& key : KeyTable()) {
    const std::string_view name = key.name;
    if (name == "load.file" || name == "load.closing_file" || name == "can.dbc") continue;
    EXPECT_TRUE(std::visit([&](auto place) { return Same(place(a), place(b)); }, key.place)) << name;
  }
  const auto expect_same_curve = [](const model::LoadCurve& x, const model::LoadCurve& y) {
    ASSERT_EQ(x.size(), y.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      EXPECT_EQ(x[i].x3_in, y[i].x3_in);
      EXPECT_EQ(x[i].p3_psi, y[i].p3_psi);
    }
  };
  expect_same_curve(a.model.load.opening, b.model.load.opening);
  EXPECT_EQ(a.model.load.has_closing, b.model.load.has_closing);
  expect_same_curve(a.model.load.closing, b.model.load.closing);
}

/// Any value of the key, as --set takes it, every bit of a number.
std::string RandomSetting(const Key& key, std::mt19937_64& random) {
  const auto number = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Configuration any;
  const std::string value = std::visit(
      [&](auto place) -> std::string {
        using Value = std::remove_reference_t<decltype(place(any))>;
        if constexpr (std::is_same_v<Value, double>) {
          std::array<char, 40> text{};
          std::snprintf(text.data(), text.size(), "%.17g", number(key.minimum, key.maximum));
          return text.data();
        } else if constexpr (std::is_same_v<Value, int>) {
          return std::to_string(static_cast<int>(number(key.minimum, key.maximum)));
        } else if constexpr (std::is_same_v<Value, bool>) {
          return random() % 2 != 0 ? "true" : "false";
        } else if constexpr (std::is_enum_v<Value>) {
          const auto names = NamesOf(Value{});
          return names[random() % names.size()];
        } else if constexpr (std::is_same_v<Value, Scale>) {
          constexpr std::array scales{"[]", "[[4.0, 0.1], [20, 300]]",
                                      "[[0, 0], [566666666666666666666.0, 300]]"};
          return scales[random() % scales.size()];
        } else if constexpr (std::is_same_v<Value, std::vector<std::string>>) {
          if (std::string_view(key.name) == "can.dbc") {
            const std::string ours = "'" + testing::ConfigFile("servohil.dbc") + "'";
            return random() % 2 != 0
                       ? ours
                       : "['" + testing::ConfigFile("examples/foreign/governor.dbc") + "', " + ours + "]";
          }
          return random() % 2 != 0 ? "['auto']" : "['slcan:pty:/tmp/a \"b\" \\c', 'é#\t', 'can1']";
        } else {
          return testing::ConfigFile("load_curve.csv");
        }
      },
      key.place);
  return std::string(key.name) + "=" + value;
}

TEST(ConfigurationText, OfTheDefaultsIsTheDefaults) {
  const testing::Scratch scratch;
  const Configuration defaults = LoadConfiguration(testing::kConfigurationFile, {});
  ExpectSame(defaults, Again(defaults, scratch / "defaults"));
}

TEST(ConfigurationText, OfAnySettingsGivesThemBackBitForBit) {
  const testing::Scratch scratch;
  std::mt19937_64 random(1);
  const auto keys = KeyTable();
  int accepted = 0;
  for (int i = 0; i < 400; ++i) {
    std::vector<std::string> settings;
    for (int k = 0; k < 10; ++k) settings.push_back(RandomSetting(keys[random() % keys.size()], random));
    Configuration configuration;
    try {
      configuration = LoadConfiguration(testing::kConfigurationFile, settings);
    } catch (const base::UsageError&) {
      continue;  // values that do not go together
    }
    ++accepted;
    ExpectSame(configuration, Again(configuration, scratch / "again"));
    ASSERT_FALSE(HasFailure()) << ConfigurationToml(configuration);
  }
  EXPECT_GT(accepted, 100);
}

TEST(ConfigurationText, NamesEveryKeyOnce) {
  const std::string text = std::string("\n").append(ConfigurationToml(Configuration{}));
  for (const Key& key : KeyTable()) {
    const std::string_view name = key.name;
    const std::size_t dot = name.rfind('.');
    const std::size_t section = text.find(std::string("\n[").append(name.substr(0, dot)).append("]\n"));
    ASSERT_NE(section, std::string::npos) << name;
    const std::size_t end = text.find("\n[", section + 1);
    const std::string body = text.substr(section, end - section);
    EXPECT_NE(body.find(std::string("\n").append(name.substr(dot + 1)).append(" = ")), std::string::npos)
        << name;
  }
}

TEST(ConfigurationText, HasSeveralDbcFilesAndWhatIsPublished) {
  const testing::Scratch scratch;
  const Configuration foreign = LoadConfiguration(testing::ConfigFile("examples/foreign/servohil.toml"), {});
  const RunTexts texts = DescribeConfiguration(foreign);
  ASSERT_EQ(texts.dbc.size(), 2U);
  const Configuration again = Again(foreign, scratch / "again");
  ExpectSame(foreign, again);
  ASSERT_EQ(again.can.publish.size(), 3U);
  EXPECT_EQ(ConfigurationToml(again), texts.configuration_toml);
  EXPECT_EQ(DescribeConfiguration(again).dbc, texts.dbc);
}

TEST(ConfigurationText, HasItsLoadByDirection) {
  const testing::Scratch scratch;
  std::ofstream(scratch / "closing.csv") << "x3_in,p3_psi\n0.125,0.1\n8,0.30000000000000004\n";
  const Configuration configuration = LoadConfiguration(
      testing::kConfigurationFile, {"load.closing_file=" + (scratch / "closing.csv").string()});
  const Configuration again = Again(configuration, scratch / "again");
  EXPECT_TRUE(again.model.load.has_closing);
  ExpectSame(configuration, again);
}

TEST(ConfigurationHash, TellsTextsApart) {
  // Empty texts: the offset basis, multiplied by the prime once for each of the four zero bytes.
  std::uint64_t four_zeros = 0xCBF2'9CE4'8422'2325U;
  for (int i = 0; i < 4; ++i) four_zeros *= 0x100'0000'01B3U;
  RunTexts empty;
  empty.dbc = {""};
  EXPECT_EQ(ConfigurationHash(empty), four_zeros);
  recording::RecordingAttributes ab;
  ab.configuration_toml += 'a';
  ab.dbc = {"b"};
  recording::RecordingAttributes a_b;
  a_b.configuration_toml.append("ab");
  EXPECT_NE(ConfigurationHash(ab), ConfigurationHash(a_b));
}

}  // namespace
}  // namespace servohil::configuration
