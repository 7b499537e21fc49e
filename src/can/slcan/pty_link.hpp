#pragma once

#include <filesystem>
#include <string>

namespace servohil::can {

/// A symbolic link to a terminal, so that it has the same name in every run. Gone with this object, unless
/// somebody has put another in its place meanwhile.
class PtyLink {
 public:
  /// Replaces a link that leads nowhere or to a pseudo-terminal (an earlier run's). With an empty `link`:
  /// nothing.
  /// @throws UsageError when something else is there, EnvironmentError when it cannot be made
  PtyLink(const std::string& link, const std::string& terminal);
  ~PtyLink();
  PtyLink(const PtyLink&) = delete;
  PtyLink& operator=(const PtyLink&) = delete;

 private:
  std::filesystem::path link_;
  std::filesystem::path terminal_;
};

}  // namespace servohil::can
