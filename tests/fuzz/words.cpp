// words FUZZER: the names that its readers know, from the program's own tables, as a libFuzzer dictionary.

#include <cstdio>
#include <set>
#include <string>
#include <string_view>

#include "can/dbc/dbc.hpp"
#include "configuration/configuration.hpp"
#include "fault/catalogue.hpp"
#include "fault_words/injection_words.hpp"
#include "signal_map/unit.hpp"
#include "simulation/quantity.hpp"

namespace {

using Words = std::set<std::string>;

void AddKeys(Words& words) {
  servohil::configuration::Configuration defaults;
  for (const servohil::configuration::Key& key : servohil::configuration::KeyTable()) {
    words.emplace(key.name);
    std::visit(
        [&](auto place) {
          using Value = std::remove_cvref_t<decltype(place(defaults))>;
          if constexpr (std::is_enum_v<Value>) {
            for (const char* name : servohil::configuration::NamesOf(Value{})) words.emplace(name);
          }
        },
        key.place);
  }
  for (const char* key :
       {"[[can.publish]]", "message", "cycle_ms", "on_change", "e2e", "data_id", "data_id_mode", "counter",
        "checksum", "signals", "quantity", "unit", "scale", "may_clip", "raw"})
    words.emplace(key);
}

void AddUnits(Words& words) {
  for (const char* base : {"psi", "in", "in/s", "ms"}) {
    const std::string all = servohil::signal_map::ConvertibleUnits(base);
    for (std::size_t at = 0; at < all.size();) {
      const std::size_t comma = std::min(all.find(", ", at), all.size());
      words.insert(all.substr(at, comma - at));
      at = comma + 2;
    }
  }
}

void AddMessages(Words& words) {
  for (const char* file :
       {"/servohil.dbc", "/examples/foreign/governor.dbc", "/examples/foreign/valve_drive.dbc"}) {
    for (const auto& message : servohil::can::ReadDbc(SERVOHIL_CONFIG_DIR + std::string(file)).messages) {
      words.insert(message.name);
      for (const auto& signal : message.signals) {
        words.insert(signal.name);
        words.insert(message.name + "." + signal.name);
        for (const auto& [value, name] : signal.value_names) words.insert(name);
      }
    }
  }
}

void AddQuantities(Words& words) {
  for (const servohil::simulation::Quantity& quantity : servohil::simulation::Quantities())
    words.emplace(quantity.name);
}

void AddFaults(Words& words) {
  for (const auto& spec : servohil::fault::Catalogue()) {
    words.emplace(spec.name);
    for (const auto& parameter : spec.parameters) {
      if (parameter.name != nullptr) words.emplace(parameter.name);
    }
  }
  for (const servohil::fault_words::CommonParameter& parameter : servohil::fault_words::CommonParameters())
    words.emplace(parameter.name);
}

void AddStatements(Words& words) {
  for (const char* word : {"VERSION \"\"",
                           "NS_ :",
                           "BS_:",
                           "BU_: ",
                           "BO_ 1 M: 8 N\n",
                           " SG_ S : 0|8@1+ (1,0) [0|0] \"\" N\n",
                           "CM_ ",
                           "CM_ BO_ 1 \"\";",
                           "CM_ SG_ 1 S \"\";",
                           "VAL_ 1 S 0 \"\" ;",
                           "SIG_VALTYPE_ 1 S : 1;",
                           "SG_MUL_VAL_ 1 S M 0-0;",
                           "BA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 1;",
                           "BA_DEF_DEF_ \"GenMsgCycleTime\" 0;",
                           "BA_ \"GenMsgCycleTime\" BO_ 1 10;",
                           "BA_DEF_ SG_ \"GenSigStartValue\" FLOAT 0 1;",
                           "BA_ \"GenSigStartValue\" SG_ 1 S 1;",
                           "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN_FD\",\"J1939PG\";",
                           "BA_ \"VFrameFormat\" BO_ 1 14;",
                           "BA_ \"CANFD_BRS\" BO_ 1 1;",
                           "@0-",
                           "@1+",
                           " m0 ",
                           " M ",
                           " m1M ",
                           "2147483649",
                           "3221225472",
                           "1e308"})
    words.emplace(word);
}

void Print(const Words& words) {
  for (const std::string& word : words) {
    std::putchar('"');
    for (const char c : word) {
      const auto byte = static_cast<unsigned char>(c);
      const bool plain = byte >= ' ' && byte < 0x7F && c != '"' && c != '\\';
      plain ? std::printf("%c", c) : std::printf("\\x%02X", unsigned{byte});
    }
    std::puts("\"");
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view fuzzer = argc == 2 ? argv[1] : "";
  const bool configuration = fuzzer == "configuration" || fuzzer == "scenario";
  const bool faults = fuzzer == "request" || fuzzer == "scenario";
  Words words;
  if (configuration) AddKeys(words);
  if (configuration) AddUnits(words);
  if (configuration || faults) AddMessages(words);
  if (configuration || faults) AddQuantities(words);
  if (faults) AddFaults(words);
  if (fuzzer == "dbc") AddStatements(words);
  Print(words);
}
