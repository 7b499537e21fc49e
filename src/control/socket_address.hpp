#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <filesystem>

#include "base/error.hpp"

namespace servohil::control {

/// @throws UsageError when the path is longer than a Unix socket's may be
inline sockaddr_un AddressOf(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string& text = path.native();
  if (text.empty() || text.size() >= sizeof address.sun_path) {
    throw base::UsageError("--control " + text + ": a socket's path has 1 to " +
                           std::to_string(sizeof address.sun_path - 1) + " characters");
  }
  std::copy(text.begin(), text.end(), address.sun_path);
  return address;
}

inline const sockaddr* AsGeneric(const sockaddr_un& address) noexcept {
  return reinterpret_cast<const sockaddr*>(&address);  // NOLINT: the sockets API's own way
}

}  // namespace servohil::control
