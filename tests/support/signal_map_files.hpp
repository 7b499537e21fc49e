#pragma once
/// A signal_map from texts: "x.toml" and "x.dbc", "y.dbc" in a directory of their own.

#include <fstream>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "scratch.hpp"
#include "signal_map/signal_map.hpp"
#include "support/paths.hpp"

namespace servohil::testing {

/// Configuration lines that publish none of our own messages.
inline const std::string kNothingPublished =
    "[publish]\nbus_ms = 0\nsafety_ms = 0\nposition_ms = 0\npressures_ms = 0\nrelay_ms = 0\nstatus_ms = 0\n";

class SignalMapFiles {
 public:
  /// `toml` follows the lines that name load table and DBC files: it begins at line 6.
  explicit SignalMapFiles(const std::string& toml, const std::vector<std::string>& dbcs) {
    std::string names;
    for (std::size_t i = 0; i < dbcs.size(); ++i) {
      const std::string name(1, static_cast<char>('x' + i));
      std::ofstream(scratch_ / (name + ".dbc").c_str()) << dbcs[i];
      names += (names.empty() ? "\"" : ", \"") + name + ".dbc\"";
    }
    std::ofstream(scratch_ / "x.toml")
        << "[load]\nfile = \"" << ConfigFile("load_curve.csv") << "\"\n[can]\ndbc = [" << names << "]\n\n"
        << toml;
  }

  configuration::Configuration Load() const {
    return configuration::LoadConfiguration(scratch_ / "x.toml", {});
  }
  signal_map::SignalMap Bind() const { return signal_map::SignalMap(Load()); }

  /// The one line that loading gives, without the directory.
  std::string Error() const {
    try {
      Bind();
    } catch (const base::UsageError& error) {
      std::string text = error.what();
      const std::string directory = (scratch_ / "").string();
      for (std::size_t at = text.find(directory); at != std::string::npos; at = text.find(directory))
        text.erase(at, directory.size());
      return text;
    }
    return "no error";
  }

 private:
  Scratch scratch_;
};

}  // namespace servohil::testing
