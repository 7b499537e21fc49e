#pragma once
/// A contract from texts: "x.toml" and "x.dbc", "y.dbc" in a directory of their own.

#include <fstream>
#include <string>
#include <vector>

#include "scratch.hpp"
#include "servohil/app/contract.hpp"
#include "servohil/error.hpp"

namespace servohil::app::testing {

class ContractFiles {
 public:
  /// `toml` follows the lines that name load table and DBC files: it begins at line 6.
  explicit ContractFiles(const std::string& toml, const std::vector<std::string>& dbcs) {
    std::string names;
    for (std::size_t i = 0; i < dbcs.size(); ++i) {
      const std::string name(1, static_cast<char>('x' + i));
      std::ofstream(scratch_ / (name + ".dbc").c_str()) << dbcs[i];
      names += (names.empty() ? "\"" : ", \"") + name + ".dbc\"";
    }
    std::ofstream(scratch_ / "x.toml")
        << "[load]\nfile = \"" SERVOHIL_CONFIG_DIR "/load_curve.csv\"\n[can]\ndbc = [" << names << "]\n\n"
        << toml;
  }

  Configuration Load() const { return LoadConfiguration(scratch_ / "x.toml", {}); }
  Contract Bind() const { return Contract(Load()); }

  /// The one line that loading gives, without the directory.
  std::string Error() const {
    try {
      Bind();
    } catch (const UsageError& error) {
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

}  // namespace servohil::app::testing
