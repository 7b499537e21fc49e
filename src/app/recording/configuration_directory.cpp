#include <fstream>
#include <iterator>

#include "servohil/app/configuration_text.hpp"
#include "servohil/app/recording/recording.hpp"
#include "servohil/error.hpp"

namespace servohil::app {
namespace {

std::string TextOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in) throw UsageError(file.string() + ": cannot be read");
  return text;
}

void WriteText(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text << std::flush;
  if (!out) throw EnvironmentError(file.string() + ": cannot be written");
}

}  // namespace

std::uint64_t ConfigurationHash(const RecordingAttributes& attributes) {
  constexpr std::uint64_t kOffsetBasis = 0xCBF2'9CE4'8422'2325U;
  constexpr std::uint64_t kPrime = 0x0000'0100'0000'01B3U;
  std::uint64_t hash = kOffsetBasis;
  for (const std::string* text : {&attributes.configuration_toml, &attributes.dbc, &attributes.load_csv,
                                  &attributes.load_closing_csv}) {
    for (const char c : *text) hash = (hash ^ static_cast<unsigned char>(c)) * kPrime;
    hash *= kPrime;  // a zero byte
  }
  return hash;
}

RecordingAttributes DescribeConfiguration(const Configuration& configuration) {
  RecordingAttributes attributes;
  attributes.configuration_toml = ConfigurationToml(configuration);
  attributes.dbc = TextOf(configuration.can.dbc);
  attributes.load_csv = TextOf(configuration.load_file);
  if (!configuration.load_closing_file.empty())
    attributes.load_closing_csv = TextOf(configuration.load_closing_file);
  return attributes;
}

std::filesystem::path WriteConfigurationDirectory(const RecordingAttributes& attributes,
                                                  const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) throw EnvironmentError(directory.string() + ": cannot be made: " + error.message());
  std::filesystem::path configuration = directory / "servohil.toml";
  WriteText(configuration, attributes.configuration_toml);
  WriteText(directory / kLoadFileName, attributes.load_csv);
  if (!attributes.load_closing_csv.empty())
    WriteText(directory / kLoadClosingFileName, attributes.load_closing_csv);
  WriteText(directory / kDbcFileName, attributes.dbc);
  return configuration;
}

}  // namespace servohil::app
