#pragma once
/// The other end of the control socket: what `servohil fault` and `servohil status` use.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace servohil::control {

/// Where a client looks: the path that it was told, else DefaultSocket(), else the only socket in
/// /run/servohil.
/// @throws UsageError when there are several
std::filesystem::path ClientSocket(const std::string& told);

class Client {
 public:
  /// @throws EnvironmentError when no servohil listens there
  explicit Client(const std::filesystem::path& path);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Sends a request and waits for its answer. @throws EnvironmentError when the other end has gone
  nlohmann::json Ask(const nlohmann::json& request);

 private:
  std::string path_;
  int fd_ = -1;
  std::string input_;
};

}  // namespace servohil::control
