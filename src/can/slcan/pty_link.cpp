#include "can/slcan/pty_link.hpp"

#include <unistd.h>

#include <system_error>

#include "base/error.hpp"

namespace servohil::can {
namespace {

namespace fs = std::filesystem;

bool MayReplace(const fs::path& link) {
  std::error_code error;
  if (!fs::is_symlink(link, error)) return !fs::exists(link, error);
  const std::string target = fs::read_symlink(link, error).string();
  return target.rfind("/dev/pts/", 0) == 0 || !fs::exists(link, error);
}

}  // namespace

PtyLink::PtyLink(const std::string& link, const std::string& terminal) : link_(link), terminal_(terminal) {
  if (link.empty()) return;
  if (!MayReplace(link_)) {
    throw base::UsageError(
        link + " exists and is no link to a pseudo-terminal: not overwritten; name another for slcan:pty");
  }
  // A rename is atomic: who opens the link finds the old terminal or the new one.
  const fs::path temporary = link + "." + std::to_string(::getpid());
  std::error_code error;
  fs::remove(temporary, error);
  fs::create_symlink(terminal_, temporary, error);
  if (!error) fs::rename(temporary, link_, error);
  if (error) {
    const std::string reason = error.message();
    fs::remove(temporary, error);
    throw base::EnvironmentError("cannot make the link " + link + " to " + terminal + ": " + reason);
  }
}

PtyLink::~PtyLink() {
  std::error_code error;
  if (!link_.empty() && fs::read_symlink(link_, error) == terminal_) fs::remove(link_, error);
}

}  // namespace servohil::can
