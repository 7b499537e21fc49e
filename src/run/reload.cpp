#include "run/reload.hpp"

#include <spdlog/spdlog.h>

#include <sstream>

#include "base/error.hpp"
#include "base/formatted.hpp"

namespace servohil::run {

namespace {

std::string Contents(const std::string& text) {
  return base::Formatted("contents %s", base::HashText(configuration::Fnv1a(text)).c_str());
}

}  // namespace

KeyValues KeyValuesOf(const configuration::RunTexts& texts) {
  std::string dbcs;
  for (const std::string& dbc : texts.dbc) dbcs += dbc + '\0';
  KeyValues values = {{"can.dbc", Contents(dbcs)},
                      {"load.file", Contents(texts.load_csv)},
                      {"load.closing_file", Contents(texts.load_closing_csv)}};
  std::istringstream lines(texts.configuration_toml);
  std::map<std::string, int> seen;
  std::string section;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t equals = line.find(" = ");
    if (equals == std::string::npos) {
      if (line.empty()) continue;
      section = line.substr(line.find_first_not_of('['), line.find(']') - line.find_first_not_of('['));
      if (const int count = ++seen[section]; count > 1) section.append(base::Formatted("[%d]", count));
    } else {
      std::string value = line.substr(equals + 3);
      if (const std::size_t unit = value.rfind("  # "); unit != std::string::npos) value.erase(unit + 1, 3);
      values.emplace(section + "." + line.substr(0, equals), value);
    }
  }
  return values;
}

std::vector<KeyChange> ChangesOf(const KeyValues& was, const KeyValues& is) {
  const auto value = [](const KeyValues& values, const std::string& key) {
    const auto found = values.find(key);
    return found == values.end() ? std::string() : found->second;
  };
  KeyValues all = was;
  all.insert(is.begin(), is.end());
  std::vector<KeyChange> changes;
  for (const auto& [key, unused] : all) {
    if (value(was, key) != value(is, key)) changes.push_back({key, value(was, key), value(is, key)});
  }
  return changes;
}

void Reloader::Reload() {
  try {
    const configuration::Configuration configuration = load_();
    const KeyValues wanted = KeyValuesOf(configuration::DescribeConfiguration(configuration));
    const std::vector<KeyChange> changes = ChangesOf(running_, wanted);
    if (changes.empty()) spdlog::info("reload: nothing has changed");
    for (const KeyChange& change : changes) {
      const auto changeable = changeable_.find(change.key);
      if (changeable == changeable_.end()) {
        spdlog::warn("reload: {} = {}: needs a restart; it runs with {}", change.key, change.is, change.was);
        continue;
      }
      changeable->second(configuration);
      running_[change.key] = change.is;
      spdlog::info("reload: {} = {} from now on, was {}", change.key, change.is, change.was);
    }
  } catch (const base::UsageError& error) {
    spdlog::error("reload: nothing is changed: {}", error.what());
  }
}

}  // namespace servohil::run
