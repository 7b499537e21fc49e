#include "configuration/configuration.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <system_error>

#include "base/error.hpp"
#include "base/nearest_name.hpp"
#include "base/readable.hpp"
#include "configuration/load_file.hpp"
#include "configuration/publish_toml.hpp"
#include "configuration/toml_error.hpp"
#include "configuration/toml_text.hpp"

namespace servohil::configuration {
namespace {

std::string Number(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

/// For `--set`: numbers that TOML writes otherwise (.15, 1e-3 is fine), else a text without its quotes.
toml::table FromBareText(const std::string& text) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error == std::errc{} && end == text.data() + text.size()) return toml::table{{"value", number}};
  return toml::table{{"value", text}};
}

/// Reads one source after the other into a configuration, remembering where each key was set.
class Loader {
 public:
  /// @param text  what stands in `file`
  void ReadText(std::string_view text, const std::filesystem::path& file) {
    try {
      const toml::table table = toml::parse(text, file.string());
      Read(table, "", file.string(), file.parent_path());
    } catch (const toml::parse_error& error) {
      throw base::UsageError(DescribeTomlError(error, text, file.string()));
    }
  }

  void Apply(const std::string& setting) {
    const std::size_t equals = setting.find('=');
    const std::string place = "--set " + setting;
    if (equals == std::string::npos || equals == 0) throw base::UsageError(place + ": expected KEY=VALUE");
    const std::string text = setting.substr(equals + 1);
    toml::table table;
    try {
      table = toml::parse("value = " + text);
    } catch (const toml::parse_error&) {
      table = FromBareText(text);
    }
    if (table.size() != 1) throw base::UsageError(place + ": expected one value");
    Set(setting.substr(0, equals), *table.get("value"), place, {});
  }

  void Apply(const KeySetting& setting) {
    const toml::table table = toml::parse("value = " + setting.value);
    Set(setting.key, *table.get("value"), setting.place, setting.directory);
  }

  /// Checks what no key can tell alone. @throws UsageError with a line for each mistake so far
  Configuration Finish() {
    ThrowMistakes();
    Try(0, [&] { CheckTogether(); });
    Try(0, [&] { ReadLoad(); });
    ThrowMistakes();
    config_.places = places_;
    return config_;
  }
  /// Keys that no source has set keep their defaults; the files among them lie beside the configuration.
  void UseDefaultsBeside(const std::filesystem::path& file) {
    config_.load_file = (file.parent_path() / config_.load_file).string();
    PutBeside(file.parent_path(), config_.can.dbc);
  }

 private:
  void ThrowMistakes() const {
    std::vector<std::string> all;
    for (const auto& [line, mistake] : mistakes_) all.push_back(mistake);
    if (!all.empty()) throw base::UsageError(all);
  }

  void CheckTogether() const {
    const model::ServoParameters& servo = config_.model.servo;
    if (!(servo.relay_piston_rod_diameter_in < servo.relay_piston_diameter_in)) {
      Fail("servo.relay_piston_rod_diameter_in", Number(servo.relay_piston_rod_diameter_in),
           "must be below servo.relay_piston_diameter_in = " + Number(servo.relay_piston_diameter_in));
    }
    if (!(config_.model.cam.lower_alpha > config_.model.cam.upper_alpha)) {
      Fail("cam.lower_alpha", Number(config_.model.cam.lower_alpha),
           "must be above cam.upper_alpha = " + Number(config_.model.cam.upper_alpha));
    }
    if (config_.start_x3_in > servo.stroke_in) {
      Fail("start.x3_in", Number(config_.start_x3_in),
           "must be 0 to servo.stroke_in = " + Number(servo.stroke_in));
    }
    if (config_.can.buses.empty()) Fail("can.buses", "[]", "must name at least one bus, e.g. \"auto\"");
    const int emulated = config_.can.emulate_bit_rate_bit_s;
    if (emulated != 0 && emulated < 10'000)
      Fail("can.emulate_bitrate", std::to_string(emulated), "must be 0 or at least 10000 bit/s");
    CheckCycle("publish.position_ms", config_.publish.position_ms);
    CheckCycle("publish.pressures_ms", config_.publish.pressures_ms);
    CheckCycle("publish.relay_ms", config_.publish.relay_ms);
    CheckCycle("publish.status_ms", config_.publish.status_ms);
    CheckCycle("publish.safety_ms", config_.publish.safety_ms);
    if (!(config_.safety.p1_minimum_psi < config_.safety.p1_maximum_psi)) {
      Fail("safety.p1_minimum_psi", Number(config_.safety.p1_minimum_psi),
           "must be below safety.p1_maximum_psi = " + Number(config_.safety.p1_maximum_psi));
    }
    CheckCycle("publish.bus_ms", config_.publish.bus_ms);
    const double dissolution_psi = config_.model.oil.dissolution_pressure_psi;
    if (dissolution_psi > 0.0 && dissolution_psi < 20.0) {
      Fail("oil.dissolution_pressure_psi", Number(dissolution_psi), "must be 0 or at least 20 psi absolute");
    }
  }

  void Read(const toml::table& table, const std::string& prefix, const std::string& file,
            const std::filesystem::path& directory) {
    for (const auto& [name, node] : table) {
      const std::string full = prefix + std::string(name.str());
      if (const toml::table* inner = node.as_table()) {
        Read(*inner, full + ".", file, directory);
      } else {
        const auto line = node.source().begin.line;
        Try(line, [&, &value = node] { Set(full, value, file + ":" + std::to_string(line), directory); });
      }
    }
  }

  static void PutBeside(const std::filesystem::path& directory, std::vector<std::string>& files) {
    for (std::string& file : files) file = (directory / file).string();
  }

  /// A mistake in one key does not hide the others.
  template <typename Act>
  void Try(std::uint32_t line, Act&& act) {
    try {
      act();
    } catch (const base::UsageError& error) {
      mistakes_.emplace(line, error.what());
    }
  }

  void Set(const std::string& name, const toml::node& node, const std::string& place,
           const std::filesystem::path& directory) {
    if (name == "can.publish") {
      config_.can.publish = ReadPublished(node, [&](const toml::node& part) {
        const toml::source_region& source = part.source();
        return source.path ? *source.path + ":" + std::to_string(source.begin.line) : place;
      });
      return;
    }
    const auto keys = KeyTable();
    const auto key = std::find_if(keys.begin(), keys.end(), [&](const Key& k) { return name == k.name; });
    if (key == keys.end()) {
      std::vector<std::string> names;
      for (const Key& k : keys) names.emplace_back(k.name);
      throw base::UsageError(place + ": unknown key " + name + "; " +
                             base::DidYouMean(name, names, "`servohil run --help-keys` lists all"));
    }
    places_[name] = place;
    std::visit([&](auto where) { Assign(*key, node, where(config_)); }, key->place);
    if (!directory.empty()) {
      if (name == "load.file") config_.load_file = (directory / config_.load_file).string();
      if (name == "load.closing_file" && !config_.load_closing_file.empty()) {
        config_.load_closing_file = (directory / config_.load_closing_file).string();
      }
      if (name == "can.dbc") PutBeside(directory, config_.can.dbc);
    }
  }

  void Assign(const Key& key, const toml::node& node, double& target) const {
    const auto value = node.value<double>();
    const bool number = node.is_floating_point() || node.is_integer();
    if (!number || !(*value >= key.minimum && *value <= key.maximum)) FailRange(key, node, "a number");
    target = *value;
  }
  void Assign(const Key& key, const toml::node& node, int& target) const {
    const auto value = node.value_exact<std::int64_t>();
    if (!value || static_cast<double>(*value) < key.minimum || static_cast<double>(*value) > key.maximum) {
      FailRange(key, node, "a whole number");
    }
    target = static_cast<int>(*value);
  }
  void Assign(const Key& key, const toml::node& node, bool& target) const {
    const auto value = node.value_exact<bool>();
    if (!value) Fail(key.name, Shown(node), "must be true or false");
    target = *value;
  }
  void Assign(const Key& key, const toml::node& node, std::string& target) const {
    const auto value = node.value_exact<std::string>();
    constexpr std::array kMayBeEmpty = {"load.closing_file", "can.command.unit",    "can.command.enable",
                                        "can.command.trip",  "can.command.counter", "can.command.checksum"};
    const bool may_be_empty = std::any_of(kMayBeEmpty.begin(), kMayBeEmpty.end(), [&](const char* name) {
      return std::string_view(key.name) == name;
    });
    if (!value || (value->empty() && !may_be_empty)) Fail(key.name, Shown(node), "must be a text in quotes");
    target = *value;
  }
  void Assign(const Key& key, const toml::node& node, std::vector<std::string>& target) const {
    std::vector<std::string> items;
    if (const auto one = node.value_exact<std::string>()) {
      items.push_back(*one);
    } else if (const toml::array* array = node.as_array()) {
      for (const toml::node& item : *array) {
        const auto text = item.value_exact<std::string>();
        if (!text) Fail(key.name, Shown(node), "must be a list of texts in quotes");
        items.push_back(*text);
      }
    } else {
      Fail(key.name, Shown(node), "must be a list of texts in quotes");
    }
    target = std::move(items);
  }
  void Assign(const Key& key, const toml::node& node, Scale& target) const {
    const auto set = places_.find(key.name);
    target = ReadScale(node, key.name, [&](const toml::node&) { return set->second; });
    if (!target.empty() && target.size() != 2)
      Fail(key.name, Shown(node), "must be two points, as [[4.0, 0.0], [20.0, 150.0]], or []");
  }
  template <typename Enum>
  requires std::is_enum_v<Enum>
  void Assign(const Key& key, const toml::node& node, Enum& target) const {
    const auto value = node.value_exact<std::string>();
    const auto names = NamesOf(target);
    std::string all;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (value == names[i]) {
        target = static_cast<Enum>(i);
        return;
      }
      all += (i == 0 ? "\"" : i + 1 == names.size() ? " or \"" : ", \"") + std::string(names[i]) + '"';
    }
    Fail(key.name, Shown(node), "must be " + all);
  }

  void ReadLoad() {
    model::LoadParameters& load = config_.model.load;
    if (const std::string why = base::WhyUnreadable(config_.load_file); !why.empty())
      Fail("load.file", config_.load_file, why + "; a copy of config/load_curve.csv will do");
    load.opening = ReadLoadCurve(config_.load_file);
    load.has_closing = !config_.load_closing_file.empty();
    if (!load.has_closing) return;
    load.closing = ReadLoadCurve(config_.load_closing_file);
    const auto check = [&](double x3_in) {
      if (load.closing.PressureAt(x3_in) <= load.opening.PressureAt(x3_in)) return;
      Fail("load.closing_file", config_.load_closing_file,
           "must nowhere be above load.file, as it is at x3 = " + Number(x3_in) + " in");
    };
    for (std::size_t i = 0; i < load.opening.size(); ++i) check(load.opening[i].x3_in);
    for (std::size_t i = 0; i < load.closing.size(); ++i) check(load.closing[i].x3_in);
  }

  void CheckCycle(const char* key, int cycle_ms) const {
    if (cycle_ms != 0 && cycle_ms * 10 < config_.loop.wake_ticks) {
      Fail(key, std::to_string(cycle_ms),
           "must be 0 or at least the wake period, loop.wake_ticks = " +
               std::to_string(config_.loop.wake_ticks) + " ticks of 0.1 ms");
    }
  }

  [[noreturn]] void FailRange(const Key& key, const toml::node& node, const std::string& kind) const {
    Fail(key.name, Shown(node),
         "must be " + kind + " from " + Number(key.minimum) + " to " + Number(key.maximum) +
             (*key.unit != 0 ? std::string(" ") + key.unit : ""));
  }
  [[noreturn]] void Fail(const std::string& key, const std::string& value, const std::string& right) const {
    const auto place = places_.find(key);
    throw base::UsageError((place != places_.end() ? place->second : "default") + ": " + key + " = " + value +
                           ": " + right);
  }

  Configuration config_;
  std::multimap<std::uint32_t, std::string> mistakes_;  ///< line → what is wrong there
  std::map<std::string, std::string> places_;           ///< key → "FILE:LINE" or "--set KEY=VALUE"
};

}  // namespace

std::filesystem::path DefaultConfigurationFile() {
  std::error_code ignored;
  // One that is there and cannot be read is a mistake to be told, not passed over.
  if (std::filesystem::path here = "config/servohil.toml"; std::filesystem::exists(here, ignored))
    return here;
  const auto program = std::filesystem::read_symlink("/proc/self/exe");
  return program.parent_path().parent_path() / "share" / "servohil" / "servohil.toml";
}

Configuration LoadConfiguration(const std::filesystem::path& file, const std::vector<std::string>& settings,
                                const std::vector<KeySetting>& more) {
  const std::filesystem::path source = file.empty() ? DefaultConfigurationFile() : file;
  base::RequireReadable(source);
  std::ifstream in(source, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  return ParseConfiguration(text, source, settings, more);
}

Configuration ParseConfiguration(std::string_view text, const std::filesystem::path& file,
                                 const std::vector<std::string>& settings,
                                 const std::vector<KeySetting>& more) {
  Loader loader;
  loader.UseDefaultsBeside(file);
  loader.ReadText(text, file);
  for (const KeySetting& setting : more) loader.Apply(setting);
  for (const std::string& setting : settings) loader.Apply(setting);
  return loader.Finish();
}

}  // namespace servohil::configuration
