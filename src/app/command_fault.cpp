#include <CLI/CLI.hpp>
#include <charconv>
#include <iostream>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "control/client.hpp"
#include "control/server.hpp"
#include "fault_document.hpp"
#include "formatted.hpp"
#include "servohil/app/ticks.hpp"
#include "servohil/error.hpp"
#include "servohil/fault/catalogue.hpp"
#include "servohil/nearest_name.hpp"

namespace servohil::app {
namespace {

using Json = nlohmann::json;

struct Options {
  std::string socket;
  std::string fault;
  std::vector<std::string> parameters;
  std::optional<double> at_s;
  bool all = false;
  bool markdown = false;
};

control::Client Connect(const Options& options) {
  return control::Client(options.socket.empty() ? control::DefaultSocket()
                                                : std::filesystem::path(options.socket));
}

/// "fraction=0.02" → {"fraction": 0.02}
Json ParametersOf(const Options& options) {
  Json parameters = Json::object();
  for (const std::string& text : options.parameters) {
    const std::size_t equals = text.find('=');
    const char* begin = text.data() + (equals == std::string::npos ? text.size() : equals + 1);
    const char* end = text.data() + text.size();
    double value = 0.0;
    const auto [parsed, error] = std::from_chars(begin, end, value);
    if (equals == 0 || begin == end || error != std::errc{} || parsed != end)
      throw UsageError("fault inject: " + text + ": expected NAME=NUMBER, such as fraction=0.02");
    parameters[text.substr(0, equals)] = value;
  }
  if (options.at_s) parameters["at_s"] = *options.at_s;
  return parameters;
}

/// Exit status of an answer; what is wrong goes to standard error.
int Judge(const Json& answer) {
  const std::string result = answer.value("result", "");
  if (result == "APPLIED" || result == "OK") return kExitOk;
  std::cerr << "servohil: " << result << ": " << answer.value("reason", "") << '\n';
  return kExitUsage;
}

int Inject(const Options& options) {
  const Json answer = Connect(options).Ask(
      {{"request", "inject"}, {"fault", options.fault}, {"parameters", ParametersOf(options)}});
  if (answer.value("result", "") == "APPLIED") {
    const auto tick = answer.value("tick", std::uint64_t{0});
    std::cout << Formatted("APPLIED: %s from tick %llu (%.4f s) on\n", options.fault.c_str(),
                           static_cast<unsigned long long>(tick), SecondsOf(tick));
  }
  return Judge(answer);
}

int Clear(const Options& options) {
  if (options.fault.empty() != options.all)
    throw UsageError("fault clear: expected the name of a fault, or --all");
  Json request = {{"request", "clear"}};
  if (!options.all) request["fault"] = options.fault;
  const Json answer = Connect(options).Ask(request);
  if (answer.value("result", "") == "APPLIED") {
    std::cout << "APPLIED: cleared from tick " << answer.value("tick", std::uint64_t{0}) << " on\n";
  }
  return Judge(answer);
}

std::string ParameterText(const fault::ParameterSpec& p) {
  return Formatted("%s=%g%s%s", p.name, p.preset, *p.unit != 0 ? " " : "", p.unit);
}

/// All there are; with the state of those that are injected, where a run can be asked.
int List(const Options& options) {
  if (options.markdown) {
    std::cout << FaultDocument();
    return kExitOk;
  }
  Json injected = Json::array();
  bool asked = false;
  try {
    injected = Connect(options).Ask({{"request", "faults"}}).value("faults", Json::array());
    asked = true;
  } catch (const EnvironmentError& error) {
    if (!options.socket.empty()) throw;
  }
  const char* part = "";
  for (const fault::Spec& spec : fault::Catalogue()) {
    if (part != fault::NameOf(spec.part)) {
      part = fault::NameOf(spec.part);
      std::cout << part << '\n';
    }
    std::string parameters;
    for (const fault::ParameterSpec& p : spec.parameters) {
      if (p.name != nullptr) parameters += (parameters.empty() ? "" : ", ") + ParameterText(p);
    }
    std::string state;
    for (const Json& one : injected) {
      if (one.value("fault", "") == spec.name)
        state = Formatted("  ** injected, %.0f %% **", 100.0 * one.value("share", 0.0));
    }
    std::cout << Formatted("  %-28s %s%s\n", spec.name, parameters.c_str(), state.c_str());
  }
  std::cout << (asked ? "" : "no servohil is running here: states are not known\n");
  return kExitOk;
}

int Show(const Options& options) {
  std::vector<std::string> names;
  for (const fault::Spec& spec : fault::Catalogue()) {
    names.emplace_back(spec.name);
    if (options.fault != spec.name) continue;
    std::cout << spec.name << " (" << fault::NameOf(spec.part) << ")\n  " << spec.effect << '\n';
    for (const fault::ParameterSpec& p : spec.parameters) {
      if (p.name == nullptr) continue;
      std::cout << Formatted("  %-16s %s; %g to %g%s%s, default %g\n", p.name, p.meaning, p.minimum,
                             p.maximum, *p.unit != 0 ? " " : "", p.unit, p.preset);
    }
    std::cout << "  at_s             start, simulated time [s]; default: now\n"
                 "  ramp_s           rises in this time, and falls again at the end [s]; default: 0\n"
                 "  for_s            ends after this time [s]; default: when cleared\n";
    if (spec.needs == fault::Needs::kFullPhysics) std::cout << "  Only with model.physics = \"full\".\n";
    if (spec.needs == fault::Needs::kStabilizer) std::cout << "  Only with stabilizer.enabled = true.\n";
    std::cout << "  servohil fault inject " << spec.name;
    for (const fault::ParameterSpec& p : spec.parameters) {
      if (p.name != nullptr) std::cout << Formatted(" %s=%g", p.name, p.preset);
    }
    std::cout << " ramp_s=0.5 for_s=3\n";
    return kExitOk;
  }
  const std::string nearest = NearestName(options.fault, names);
  throw UsageError("fault show: there is no fault " + options.fault +
                   (nearest.empty() ? "; `servohil fault list` has all" : "; did you mean " + nearest + "?"));
}

int ShowStatus(const Options& options) {
  const Json answer = Connect(options).Ask({{"request", "status"}});
  for (const auto& [name, value] : answer.items()) {
    if (name != "id" && name != "result")
      std::cout << Formatted("%-18s ", name.c_str())
                << (value.is_string() ? value.get<std::string>() : value.dump()) << '\n';
  }
  return Judge(answer);
}

void AddSocket(CLI::App& command, Options& options) {
  command.add_option("--control", options.socket, "control socket of the run; default: as `servohil run`'s")
      ->type_name("PATH");
}

}  // namespace

void AddFaultCommand(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<Options>();
  CLI::App& command =
      *program.add_subcommand("fault", "Injects faults into a running emulator, lists, clears them");
  command.require_subcommand(1);
  const auto add = [&](const char* name, const char* description, int (*act)(const Options&)) {
    CLI::App* sub = command.add_subcommand(name, description);
    AddSocket(*sub, *options);
    sub->callback([options, act, &exit_status] { exit_status = act(*options); });
    return sub;
  };
  CLI::App* inject =
      add("inject", "Injects a fault: fault inject air_entrainment fraction=0.02 ramp_s=0.5 for_s=3", Inject);
  inject->add_option("fault", options->fault, "its name; `servohil fault list` has all")->required();
  inject->add_option("parameters", options->parameters, "NAME=NUMBER: the fault's own, ramp_s, for_s")
      ->type_name("NAME=NUMBER");
  inject->add_option("--at", options->at_s, "simulated time at which it starts [s]; default: now")
      ->type_name("S")
      ->check(CLI::Range(0.0, 1e6));
  CLI::App* list = add("list", "All faults, their parameters with defaults, and which are injected", List);
  list->add_flag("--markdown", options->markdown, "the catalogue as FAULTS.md has it; asks no run");
  CLI::App* show = add("show", "One fault: effect, parameters, ranges", Show);
  show->add_option("fault", options->fault, "its name")->required();
  CLI::App* clear =
      add("clear", "Ends a fault, or all: the parameters are then exactly the unfaulted ones", Clear);
  clear->add_option("fault", options->fault, "its name");
  clear->add_flag("--all", options->all, "all of them");
}

void AddStatusCommand(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<Options>();
  CLI::App& command = *program.add_subcommand("status", "State of a running emulator");
  AddSocket(command, *options);
  command.callback([options, &exit_status] { exit_status = ShowStatus(*options); });
}

}  // namespace servohil::app
