#include <CLI/CLI.hpp>
#include <charconv>
#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/exit_status.hpp"
#include "base/formatted.hpp"
#include "commands/commands.hpp"
#include "control/client.hpp"
#include "control/server.hpp"
#include "fault/catalogue.hpp"
#include "fault_words/document.hpp"
#include "fault_words/injection_words.hpp"
#include "model/ticks.hpp"

namespace servohil::commands {
namespace {

using Json = nlohmann::json;

struct FaultOptions {
  std::string socket;
  std::string fault;
  std::vector<std::string> parameters;
  bool all = false;
  bool markdown = false;
};

control::Client Connect(const FaultOptions& options) {
  return control::Client(control::ClientSocket(options.socket));
}

/// "fraction=0.02" → {"fraction": 0.02}; what is no number is a text: "signal=x3".
Json ParametersOf(const FaultOptions& options) {
  Json parameters = Json::object();
  for (const std::string& text : options.parameters) {
    const std::size_t equals = text.find('=');
    if (equals == 0 || equals == std::string::npos || equals + 1 == text.size())
      throw base::UsageError("fault inject: " + text + ": expected NAME=VALUE, such as fraction=0.02");
    const char* begin = text.data() + equals + 1;
    const char* end = text.data() + text.size();
    double value = 0.0;
    const auto [parsed, error] = std::from_chars(begin, end, value);
    const bool is_number = error == std::errc{} && parsed == end;
    parameters[text.substr(0, equals)] = is_number ? Json(value) : Json(text.substr(equals + 1));
  }
  return parameters;
}

/// Exit status of an answer; what is wrong goes to standard error.
int Judge(const Json& answer) {
  const std::string result = answer.value("result", "");
  if (result == "APPLIED" || result == "OK") return base::kExitOk;
  std::cerr << "servohil: " << result << ": " << answer.value("reason", "") << '\n';
  return base::kExitUsage;
}

int Inject(const FaultOptions& options) {
  const Json answer = Connect(options).Ask(
      {{"request", "inject"}, {"fault", options.fault}, {"parameters", ParametersOf(options)}});
  if (answer.value("result", "") == "APPLIED") {
    const auto tick = answer.value("tick", std::uint64_t{0});
    std::cout << base::Formatted("APPLIED: %s from tick %llu (%.4f s) on\n", options.fault.c_str(),
                                 static_cast<unsigned long long>(tick), model::SecondsOf(tick));
    if (const std::string warning = answer.value("warning", ""); !warning.empty())
      std::cerr << "servohil: warning: " << warning << '\n';
  }
  return Judge(answer);
}

int Clear(const FaultOptions& options) {
  if (options.fault.empty() != options.all)
    throw base::UsageError("fault clear: expected the name of a fault, or --all");
  Json request = {{"request", "clear"}};
  if (!options.all) request["fault"] = options.fault;
  request["parameters"] = ParametersOf(options);
  const Json answer = Connect(options).Ask(request);
  if (answer.value("result", "") == "APPLIED") {
    std::cout << "APPLIED: cleared from tick " << answer.value("tick", std::uint64_t{0}) << " on\n";
  }
  return Judge(answer);
}

std::string ParameterText(const fault::ParameterSpec& p) {
  return base::Formatted("%s=%g%s%s", p.name, p.preset, *p.unit != 0 ? " " : "", p.unit);
}

/// "  ** on x3_in: 100 % **" of one that is injected.
std::string StateOf(const Json& injected) {
  const Json& parameters = injected.at("parameters");
  const std::string target = parameters.value("signal", parameters.value("message", ""));
  const double share = injected.value("share", 0.0);
  std::string state = base::Formatted("%.0f %%", 100.0 * share);
  if (injected.value("waits", false)) state = "waits for " + injected.value("trigger", "");
  return "  ** " + (target.empty() ? "injected, " : "on " + target + ": ") + state + " **";
}

/// All there are; with the state of those that are injected, where a run can be asked.
int List(const FaultOptions& options) {
  if (options.markdown) {
    std::cout << fault_words::FaultDocument();
    return base::kExitOk;
  }
  Json injected = Json::array();
  bool asked = false;
  try {
    injected = Connect(options).Ask({{"request", "faults"}}).value("faults", Json::array());
    asked = true;
  } catch (const base::EnvironmentError& error) {
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
      if (one.value("fault", "") == spec.name) state += StateOf(one);
    }
    std::cout << base::Formatted("  %-28s %s%s\n", spec.name, parameters.c_str(), state.c_str());
  }
  std::cout << (asked ? "" : "no servohil is running here: states are not known\n");
  return base::kExitOk;
}

std::string CommonText(const fault_words::CommonParameter& p) {
  const std::string range = p.minimum == p.maximum ? ""
                                                   : base::Formatted("; %g to %g%s%s", p.minimum, p.maximum,
                                                                     *p.unit != 0 ? " " : "", p.unit);
  const std::string preset = *p.preset == 0 ? "" : base::Formatted(", default %s", p.preset);
  return base::Formatted("  %-16s %s%s%s\n", p.name, p.meaning, (range.empty() ? ";" : range.c_str()),
                         preset.c_str());
}

int Show(const FaultOptions& options) {
  const fault::Spec& spec = fault_words::RequireFault(options.fault);
  std::cout << spec.name << " (" << fault::NameOf(spec.part) << ")\n  " << spec.effect << '\n';
  for (const fault::ParameterSpec& p : spec.parameters) {
    if (p.name == nullptr) break;
    std::cout << base::Formatted("  %-16s %s; %g to %g%s%s, default %g\n", p.name, p.meaning, p.minimum,
                                 p.maximum, *p.unit != 0 ? " " : "", p.unit, p.preset);
  }
  for (const fault_words::CommonParameter& p : fault_words::CommonParameters()) {
    if (p.fits(spec)) std::cout << CommonText(p);
  }
  if (const char* only = fault::OnlyWith(spec.needs)) std::cout << "  Only with " << only << ".\n";
  std::cout << "  " << fault_words::ExampleLine(spec) << '\n';
  return base::kExitOk;
}

void AddSocket(CLI::App& command, FaultOptions& options) {
  command.add_option("--control", options.socket, "control socket of the run; default: as `servohil run`'s")
      ->type_name("PATH");
}

}  // namespace

void AddFaultCommand(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<FaultOptions>();
  CLI::App& command =
      *program.add_subcommand("fault", "Injects faults into a running emulator, lists, clears them");
  command.require_subcommand(1);
  const auto add = [&](const char* name, const char* description, int (*act)(const FaultOptions&)) {
    CLI::App* sub = command.add_subcommand(name, description);
    AddSocket(*sub, *options);
    sub->callback([options, act, &exit_status] { exit_status = act(*options); });
    return sub;
  };
  CLI::App* inject =
      add("inject", "Injects a fault: fault inject air_entrainment fraction=0.02 ramp_s=0.5 for_s=3", Inject);
  inject->add_option("fault", options->fault, "its name; `servohil fault list` has all")->required();
  inject
      ->add_option("parameters", options->parameters,
                   "NAME=VALUE: the fault's own and those that all have; `servohil fault show NAME`")
      ->type_name("NAME=VALUE");
  // Parameters that read better as options.
  const auto also = [&](const char* option, const char* parameter, const char* type, const char* meaning) {
    inject
        ->add_option_function<std::string>(
            option,
            [options, name = std::string(parameter)](const std::string& value) {
              options->parameters.push_back(name + "=" + value);
            },
            meaning)
        ->type_name(type);
  };
  also("--at", "at_s", "S", "simulated time at which it starts [s]; default: now");
  also("--when", "when", "CONDITION", "starts when this comes true: 'x3_in > 5', 'p3_psi < 40'");
  also("--when-frame", "when_frame", "ID", "starts when the frame with this identifier is received: 0x100");
  also("--when-fault", "when_fault", "NAME", "starts with the tick after the start of this other fault");
  also("--every", "every_s", "S", "starts again each time that this has passed [s]");
  also("--duty", "duty", "SHARE", "share of --every for which it lasts; default: 0.5");
  also("--times", "times", "N", "how often; 0: without end");
  CLI::App* list = add("list", "All faults, their parameters with defaults, and which are injected", List);
  list->add_flag("--markdown", options->markdown, "the catalogue as FAULTS.md has it; asks no run");
  CLI::App* show = add("show", "One fault: effect, parameters, ranges", Show);
  show->add_option("fault", options->fault, "its name")->required();
  CLI::App* clear =
      add("clear", "Ends a fault, or all: the parameters are then exactly the unfaulted ones", Clear);
  clear->add_option("fault", options->fault, "its name");
  clear->add_option("parameters", options->parameters, "signal=NAME or message=NAME: there alone")
      ->type_name("NAME=VALUE");
  clear->add_flag("--all", options->all, "all of them");
}

}  // namespace servohil::commands
