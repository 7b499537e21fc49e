#include "configuration/run_texts.hpp"

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "base/error.hpp"
#include "configuration/configuration_text.hpp"

namespace servohil::configuration {
namespace {

std::string TextOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in) throw base::UsageError(file.string() + ": cannot be read");
  return text;
}

void WriteText(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text << std::flush;
  if (!out) throw base::EnvironmentError(file.string() + ": cannot be written");
}

}  // namespace

std::uint64_t Fnv1a(std::string_view text, std::uint64_t hash) noexcept {
  constexpr std::uint64_t kPrime = 0x0000'0100'0000'01B3U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * kPrime;
  return hash;
}

std::uint64_t ConfigurationHash(const RunTexts& texts) {
  std::vector<const std::string*> all = {&texts.configuration_toml};
  for (const std::string& dbc : texts.dbc) all.push_back(&dbc);
  all.insert(all.end(), {&texts.load_csv, &texts.load_closing_csv});
  std::uint64_t hash = Fnv1a({});
  constexpr char kEndOfText = '\0';
  for (const std::string* text : all) hash = Fnv1a({&kEndOfText, 1}, Fnv1a(*text, hash));
  return hash;
}

RunTexts DescribeConfiguration(const Configuration& configuration) {
  RunTexts texts;
  texts.configuration_toml = ConfigurationToml(configuration);
  for (const std::string& file : configuration.can.dbc) texts.dbc.push_back(TextOf(file));
  texts.load_csv = TextOf(configuration.load_file);
  if (!configuration.load_closing_file.empty())
    texts.load_closing_csv = TextOf(configuration.load_closing_file);
  return texts;
}

std::filesystem::path WriteConfigurationDirectory(const RunTexts& texts,
                                                  const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) throw base::EnvironmentError(directory.string() + ": cannot be made: " + error.message());
  std::filesystem::path configuration = directory / "servohil.toml";
  WriteText(configuration, texts.configuration_toml);
  WriteText(directory / kLoadFileName, texts.load_csv);
  if (!texts.load_closing_csv.empty()) WriteText(directory / kLoadClosingFileName, texts.load_closing_csv);
  for (std::size_t i = 0; i < texts.dbc.size(); ++i) WriteText(directory / DbcFileName(i), texts.dbc[i]);
  return configuration;
}

TemporaryConfiguration::TemporaryConfiguration(const RunTexts& texts) {
  std::error_code error;
  std::string name = (std::filesystem::temp_directory_path(error) / "servohil-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw base::EnvironmentError(name + ": cannot be made");
  directory_ = name;
  file_ = WriteConfigurationDirectory(texts, directory_);
}

TemporaryConfiguration::~TemporaryConfiguration() {
  std::error_code error;
  std::filesystem::remove_all(directory_, error);
}

}  // namespace servohil::configuration
