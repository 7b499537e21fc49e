#pragma once
/// The texts that make a run what it is. Recordings and snapshots carry them, so that they stand alone.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "configuration/configuration.hpp"

namespace servohil::configuration {

struct RunTexts {
  std::string configuration_toml;  ///< ConfigurationToml()
  std::vector<std::string> dbc;    ///< text of each file
  std::string load_csv;
  std::string load_closing_csv;  ///< empty: one curve for both directions
};

/// FNV-1a, 64 bits; `hash` is that of what came before. Not cryptographic. Source: G. Fowler, L. C. Noll,
/// K.-P. Vo, D. Eastlake, "The FNV Non-Cryptographic Hash Algorithm", draft-eastlake-fnv.
std::uint64_t Fnv1a(std::string_view text, std::uint64_t hash = 0xCBF2'9CE4'8422'2325U) noexcept;

/// Fnv1a over configuration, DBC files and both load tables, each followed by a zero byte. Runs of the same
/// hash had the same model and the same signal_map.
std::uint64_t ConfigurationHash(const RunTexts& texts);

/// The configuration with the files that it names, as they are now.
/// @throws UsageError when one of them cannot be read
RunTexts DescribeConfiguration(const Configuration& configuration);

/// Lays out servohil.toml, load_curve.csv, load_closing.csv (where there is one) and the DBC files in
/// `directory`, which is created: LoadConfiguration(directory / "servohil.toml", ...) gives the same one.
/// @return the path of servohil.toml
/// @throws EnvironmentError when a file cannot be written
std::filesystem::path WriteConfigurationDirectory(const RunTexts& texts,
                                                  const std::filesystem::path& directory);

/// A configuration directory for as long as this lives.
class TemporaryConfiguration {
 public:
  /// @throws EnvironmentError when there is no place for it
  explicit TemporaryConfiguration(const RunTexts& texts);
  ~TemporaryConfiguration();
  TemporaryConfiguration(const TemporaryConfiguration&) = delete;
  TemporaryConfiguration& operator=(const TemporaryConfiguration&) = delete;

  const std::filesystem::path& File() const noexcept { return file_; }

 private:
  std::filesystem::path directory_;
  std::filesystem::path file_;
};

}  // namespace servohil::configuration
