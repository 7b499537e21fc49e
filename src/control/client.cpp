#include "control/client.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <vector>

#include "base/error.hpp"
#include "control/server.hpp"
#include "control/socket_address.hpp"

namespace servohil::control {
namespace {

using Json = nlohmann::json;

constexpr timeval kPatience = {10, 0};

}  // namespace

std::filesystem::path ClientSocket(const std::string& told) {
  if (!told.empty()) return told;
  std::error_code error;
  std::filesystem::path usual = DefaultSocket();
  if (std::filesystem::exists(usual, error)) return usual;
  std::vector<std::filesystem::path> sockets;
  for (const auto& entry : std::filesystem::directory_iterator("/run/servohil", error)) {
    if (entry.path().extension() == ".sock") sockets.push_back(entry.path());
  }
  if (sockets.size() > 1) {
    throw base::UsageError("more than one servohil runs here: --control " + sockets[0].string() +
                           ", --control " + sockets[1].string() + (sockets.size() > 2 ? ", ..." : ""));
  }
  return sockets.empty() ? usual : sockets[0];
}

Client::Client(const std::filesystem::path& path)
    : path_(path.string()), fd_(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  const sockaddr_un address = AddressOf(path);
  if (connect(fd_, AsGeneric(address), sizeof address) != 0) {
    const int error = errno;
    close(fd_);
    throw base::EnvironmentError(
        path_ + ": no servohil to be reached here (" + std::generic_category().message(error) +
        "): is `servohil run` running? Its ready line tells its control socket: --control PATH");
  }
  setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &kPatience, sizeof kPatience);
}

Client::~Client() {
  close(fd_);
}

Json Client::Ask(const Json& request) {
  const std::string line = request.dump() + '\n';
  const bool sent = send(fd_, line.data(), line.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(line.size());
  std::size_t end = std::string::npos;
  while (sent && (end = input_.find('\n')) == std::string::npos) {
    std::array<char, 4'096> bytes{};
    const ssize_t size = recv(fd_, bytes.data(), bytes.size(), 0);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) break;
    input_.append(bytes.data(), static_cast<std::size_t>(size));
  }
  if (end == std::string::npos)
    throw base::EnvironmentError(path_ + ": servohil does not answer: it has ended or hangs");
  Json answer = Json::parse(input_.substr(0, end), nullptr, false);
  input_.erase(0, end + 1);
  if (!answer.is_object()) throw base::EnvironmentError(path_ + ": this is not servohil's control socket");
  return answer;
}

}  // namespace servohil::control
