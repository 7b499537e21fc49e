#include <unistd.h>
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <thread>

#include "base/exit_status.hpp"
#include "commands/commands.hpp"
#include "control/client.hpp"
#include "control/status_view.hpp"

namespace servohil::commands {
namespace {

using Json = nlohmann::json;

struct StatusOptions {
  std::string socket;
  bool watch = false;
  bool json = false;
};

/// The cursor may be moved: a terminal, and not a dumb one.
bool CanRedraw() {
  const char* terminal = std::getenv("TERM");
  return isatty(STDOUT_FILENO) != 0 && terminal != nullptr && std::string(terminal) != "dumb";
}

std::string Describe(control::Client& client, bool json) {
  const Json status = client.Ask({{"request", "status"}});
  if (json) return status.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n';
  return control::StatusView(status, client.Ask({{"request", "faults"}}));
}

int ShowStatus(const StatusOptions& options) {
  control::Client client(control::ClientSocket(options.socket));
  if (!options.watch) {
    std::cout << Describe(client, options.json);
    return base::kExitOk;
  }
  constexpr std::chrono::milliseconds kEvery{500};
  const bool redraw = !options.json && CanRedraw();
  const char* const before = redraw ? "\033[H" : "";  // to the top; each line clears its rest, below it all
  const char* const after = redraw ? "\033[J" : options.json ? "" : "\n";
  if (redraw) std::cout << "\033[2J";
  while (std::cout) {
    std::string text = Describe(client, options.json);
    for (std::size_t end = 0; redraw && (end = text.find('\n', end)) != std::string::npos; end += 4)
      text.replace(end, 1, "\033[K\n");
    std::cout << before << text << after << std::flush;
    std::this_thread::sleep_for(kEvery);
  }
  return base::kExitOk;
}

}  // namespace

void AddStatusCommand(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<StatusOptions>();
  CLI::App& command =
      *program.add_subcommand("status", "State of a running emulator: values, bars, faults, warnings");
  command
      .add_option("--control", options->socket,
                  "control socket of the run; default: as `servohil run`'s, or the only one in /run/servohil")
      ->type_name("PATH");
  command.add_flag("--watch", options->watch, "twice a second, until Ctrl-C or the end of the run");
  command.add_flag("--json", options->json, "the answer of the control socket, a line each");
  command.callback([options, &exit_status] { exit_status = ShowStatus(*options); });
}

}  // namespace servohil::commands
