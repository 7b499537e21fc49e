#pragma once
/// The configuration file (TOML) and `--set KEY=VALUE`. Every key stands in one table, KeyTable(), which
/// reading, checking, help and the tests share.

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "configuration/safety_settings.hpp"
#include "configuration/signal_map_settings.hpp"
#include "model/parameters.hpp"

namespace servohil::configuration {

/// What happens when more ticks are to be caught up than loop.max_catch_up_ticks.
enum class Overrun : std::uint8_t { kCatchUp, kFreeze, kStop };

struct LoopSettings {
  int wake_ticks = 10;  ///< ticks of 0.1 ms per wake-up
  int priority = 80;    ///< SCHED_FIFO
  int cpu = -1;         ///< -1: any
  Overrun overrun = Overrun::kCatchUp;
  int max_catch_up_ticks = 1000;
  int grace_ms = 0;  ///< at the start: late ticks are told, but do not make the run invalid
};

/// Whether faults may be injected.
enum class Armed : std::uint8_t { kAuto, kYes, kNo };

struct FaultSettings {
  Armed armed = Armed::kAuto;  ///< kAuto: where no bus is physical
  bool allow_can = false;      ///< FAULT_Request frames are followed, where faults are armed
};

struct LockstepSettings {
  int ticks = 100;   ///< of 0.1 ms per frame that lets time pass
  int sync_id = -1;  ///< standard identifier of that frame; -1: the command frame
};

struct CanSettings {
  std::vector<std::string> dbc = {"servohil.dbc"};
  std::vector<std::string> buses = {"auto"};
  std::vector<std::string> interfaces = {"vcan0", "can0"};
  int bit_rate_bit_s = 500'000;
  int data_bit_rate_bit_s = 2'000'000;  ///< of CAN FD frames with bit-rate switch
  bool allow_physical = false;
  bool configure = false;  ///< sets up kernel interfaces at the start
  double sample_point = 0.875;
  int restart_ms = 100;  ///< of the kernel, after bus-off; 0: the emulator restarts, by the two below
  int backoff_ms = 100;
  int most_backoff_ms = 10'000;
  int queue_length = 16;
  int emulate_bit_rate_bit_s = 0;  ///< 0: not emulated
  CommandSettings command;
  std::vector<MessageSettings> publish;  ///< empty: servohil's own messages, PublishSettings
};

/// Cycle times of the published messages [ms]; 0: not sent.
struct PublishSettings {
  int position_ms = 10;
  int pressures_ms = 10;
  int relay_ms = 100;
  int status_ms = 100;
  int safety_ms = 100;
  int bus_ms = 1000;
};

struct Configuration {
  model::Parameters model;
  std::string load_file = "load_curve.csv";
  std::string load_closing_file;  ///< empty: one curve for both directions
  double start_x3_in = 4.0;
  LoopSettings loop;
  LockstepSettings lockstep;
  FaultSettings fault;
  SafetySettings safety;
  CanSettings can;
  PublishSettings publish;
  std::map<std::string, std::string> places;  ///< key → "FILE:LINE" or "--set KEY=VALUE", where one set it

  /// Where a key was set; "default": nowhere.
  std::string PlaceOf(const std::string& key) const {
    const auto place = places.find(key);
    return place == places.end() ? "default" : place->second;
  }
};

/// Where a key's value lives in a Configuration.
using Place = std::variant<double& (*)(Configuration&), int& (*)(Configuration&), bool& (*)(Configuration&),
                           std::string& (*)(Configuration&), std::vector<std::string>& (*)(Configuration&),
                           model::Physics& (*)(Configuration&), model::OilName& (*)(Configuration&),
                           model::CamShape& (*)(Configuration&), model::LoadBeyond& (*)(Configuration&),
                           Overrun& (*)(Configuration&), Armed& (*)(Configuration&),
                           Scale& (*)(Configuration&), OnLoss& (*)(Configuration&),
                           can::E2eProfile& (*)(Configuration&), can::DataIdMode& (*)(Configuration&)>;

struct Key {
  const char* name;  ///< "servo.underlap_in"
  const char* unit;  ///< "in"; empty where there is none
  double minimum;    ///< numbers only, inclusive
  double maximum;
  const char* meaning;  ///< one line, with the symbol and source
  Place place;
};

std::span<const Key> KeyTable();

/// The names that a choice has in the file, in the order of its enumerators.
inline std::span<const char* const> NamesOf(model::Physics) {
  static constexpr const char* kNames[] = {"thesis", "full"};
  return kNames;
}
inline std::span<const char* const> NamesOf(model::OilName) {
  static constexpr const char* kNames[] = {"custom", "mil_h_5606", "iso_vg_32"};
  return kNames;
}
inline std::span<const char* const> NamesOf(model::CamShape) {
  static constexpr const char* kNames[] = {"single", "two_slope"};
  return kNames;
}
inline std::span<const char* const> NamesOf(model::LoadBeyond) {
  static constexpr const char* kNames[] = {"extrapolate", "hold"};
  return kNames;
}

inline std::span<const char* const> NamesOf(Armed) {
  static constexpr const char* kNames[] = {"auto", "yes", "no"};
  return kNames;
}
inline std::span<const char* const> NamesOf(Overrun) {
  static constexpr const char* kNames[] = {"catch_up", "freeze", "stop"};
  return kNames;
}

/// One key, set elsewhere than in the configuration file.
struct KeySetting {
  std::string key;
  std::string value;                ///< as TOML writes it
  std::string place;                ///< "FILE:LINE", for messages
  std::filesystem::path directory;  ///< to which a path in `value` is relative
};

/// Reads `file` (or the default configuration when empty), applies `more` and then `settings` ("KEY=VALUE")
/// in order, reads the load table, checks everything. Relative paths in the file are relative to the file, in
/// `settings` to the current directory.
/// @throws UsageError, one line for each mistake: file, line, key, value and what would be right
Configuration LoadConfiguration(const std::filesystem::path& file, const std::vector<std::string>& settings,
                                const std::vector<KeySetting>& more = {});
/// The same for what stands in `file`.
Configuration ParseConfiguration(std::string_view text, const std::filesystem::path& file,
                                 const std::vector<std::string>& settings,
                                 const std::vector<KeySetting>& more = {});

/// The configuration that applies without -c: ./config/servohil.toml, else the installed one beside the
/// program.
std::filesystem::path DefaultConfigurationFile();

/// "servo.underlap_in = 0.002 in   0 to 0.05   U, underlap ..." for every key: what `--help` shows.
std::string DescribeKeys();

}  // namespace servohil::configuration
