#pragma once
/// SIGHUP: the configuration is read again. What may change while it runs does; the rest is told.

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "configuration/configuration.hpp"
#include "configuration/run_texts.hpp"

namespace servohil::run {

/// A configuration key → its value as TOML. Files that the configuration names: the hash of what stands in
/// them.
using KeyValues = std::map<std::string, std::string>;
KeyValues KeyValuesOf(const configuration::RunTexts& texts);

struct KeyChange {
  std::string key;
  std::string was;
  std::string is;
};
/// In the order of the keys; one that is missing on one side has an empty value there.
std::vector<KeyChange> ChangesOf(const KeyValues& was, const KeyValues& is);

class Reloader {
 public:
  /// Makes a new configuration take effect, as far as its key goes.
  using Apply = std::function<void(const configuration::Configuration&)>;

  /// @param load  reads the configuration as at the start; throws as LoadConfiguration
  /// @param changeable  the keys that may change while it runs. All must outlive it what they refer to.
  Reloader(const configuration::RunTexts& running, std::function<configuration::Configuration()> load,
           std::map<std::string, Apply> changeable)
      : running_(KeyValuesOf(running)), load_(std::move(load)), changeable_(std::move(changeable)) {}

  /// Tells each change in one line. A mistake in the new configuration is told, and nothing changes.
  void Reload();

 private:
  KeyValues running_;
  std::function<configuration::Configuration()> load_;
  std::map<std::string, Apply> changeable_;
};

}  // namespace servohil::run
