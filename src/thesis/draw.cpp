#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>

#include "base/error.hpp"
#include "thesis/figures.hpp"

namespace servohil::thesis {
namespace {

/// Beside the program's data when installed; the build tree links share/servohil to the sources' config,
/// beside which the tools lie.
std::filesystem::path FindTool(const char* name) {
  const auto program = std::filesystem::read_symlink("/proc/self/exe");
  const auto data = program.parent_path().parent_path() / "share" / "servohil";
  for (const auto& folder : {data / "tools", data / ".." / "tools"})
    if (std::filesystem::exists(folder / name)) return folder / name;
  throw base::EnvironmentError("no " + (data / "tools" / name).string() + ": the installation is incomplete");
}

}  // namespace

void DrawFigures(const std::filesystem::path& folder) {
  const std::string tool = FindTool("plot_figures.py").string();
  const std::string where = folder.string();
  const char* const python = "/usr/bin/python3";  // Debian's: another may lack matplotlib
  const pid_t child = fork();
  if (child < 0)
    throw base::EnvironmentError(std::string("cannot start ") + python + ": " +
                                 std::generic_category().message(errno));
  if (child == 0) {
    execl(python, python, tool.c_str(), where.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127)
    throw base::EnvironmentError(std::string(python) +
                                 " is missing: sudo apt install python3 python3-matplotlib");
  if (WIFEXITED(status) && WEXITSTATUS(status) == 3)
    throw base::EnvironmentError(
        "drawing needs matplotlib: sudo apt install python3-matplotlib (the CSV files are in " + where + ")");
  throw base::EnvironmentError(tool + " failed; the CSV files are in " + where);
}

}  // namespace servohil::thesis
