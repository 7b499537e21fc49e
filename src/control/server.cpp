#include "control/server.hpp"

#include <grp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "control/bus_status.hpp"
#include "control/socket_address.hpp"
#include "control/status.hpp"

namespace servohil::control {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxClients = 16;
constexpr std::size_t kLongestLine = 4'096;
constexpr std::size_t kMaxOutput = std::size_t{256} * 1'024;
constexpr std::size_t kMaxSamples = std::size_t{64} * 1'024;  // bytes of samples that wait to be read
constexpr int kMaxReadsAtOnce = 4;
constexpr std::size_t kMaxAsked = 60;  // fewer than the simulation's answers have room

std::string Reason() {
  return std::generic_category().message(errno);
}

bool SomebodyListens(const sockaddr_un& address) {
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const bool listens = connect(fd, AsGeneric(address), sizeof address) == 0;
  close(fd);
  return listens;
}

/// The other side has closed: not only its half, it reads no more either.
bool HungUp(int fd) {
  pollfd descriptor = {fd, 0, 0};
  return poll(&descriptor, 1, 0) == 1 && (descriptor.revents & POLLHUP) != 0;
}

/// Bound with mode 0660 from the first moment on.
void Bind(int fd, const std::filesystem::path& path) {
  const sockaddr_un address = AddressOf(path);
  if (SomebodyListens(address)) {
    throw base::EnvironmentError(
        path.string() + ": another servohil has this control socket; --control PATH gives this one its own");
  }
  std::error_code error;
  if (std::filesystem::is_socket(path, error)) std::filesystem::remove(path, error);
  const mode_t before = umask(0117);
  const bool bound = bind(fd, AsGeneric(address), sizeof address) == 0;
  umask(before);
  if (!bound || listen(fd, kMaxClients) != 0)
    throw base::EnvironmentError(path.string() + ": no control socket can be made here: " + Reason());
  if (const group* servohil = getgrnam("servohil")) {
    // Without the right to it the socket stays the user's own.
    static_cast<void>(chown(path.c_str(), static_cast<uid_t>(-1), servohil->gr_gid) == 0);
  }
}

}  // namespace

Server::Server(std::filesystem::path path, emulator::Emulator& emulator, fault_words::Permissions permissions)
    : path_(std::move(path)),
      emulator_(emulator),
      permissions_(std::move(permissions)),
      fd_(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
  try {
    Bind(fd_, path_);
  } catch (...) {
    close(fd_);
    throw;
  }
}

Server::~Server() {
  for (const Client& client : clients_) close(client.fd);
  close(fd_);
  std::error_code error;
  std::filesystem::remove(path_, error);
}

void Server::AddTo(std::vector<pollfd>& descriptors) const {
  constexpr short kInput = POLLIN;
  constexpr short kOutput = POLLOUT;
  constexpr short kNothing = 0;
  descriptors.push_back({fd_, kInput, 0});
  for (const Client& client : clients_) {
    // One that has ended is readable for ever: not to be waited for.
    const short input = client.ended ? kNothing : kInput;
    const short output = client.output.empty() ? kNothing : kOutput;
    descriptors.push_back({client.fd, static_cast<short>(input | output), 0});
  }
}

void Server::Serve(simulation::RunState& now, const std::vector<can::BusReport>& buses) {
  now_ = &now;
  buses_ = buses;
  ServeClients();
  AcceptPendingClients();
}

void Server::ServeClients() {
  TakeAnswers();
  for (Client& client : clients_) Read(client);
  TakeAnswers();
  PassSamplesOn();
  for (Client& client : clients_) Write(client);
  clients_.remove_if([this](const Client& client) {
    const bool gone =
        client.lost || HungUp(client.fd) || (client.ended && client.output.empty() && !IsOwed(client));
    if (gone) close(client.fd);
    return gone;
  });
  ChooseSamples();
}

void Server::AcceptPendingClients() {
  constexpr int kMaxAtOnce = 64;
  for (int i = 0; i < kMaxAtOnce; ++i) {
    Client client;
    client.fd = accept4(fd_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (client.fd < 0) return;
    // Whoever had gone before this one came makes room for it.
    if (clients_.size() == kMaxClients) ServeClients();
    if (clients_.size() == kMaxClients) {
      Refuse(client.fd);
      continue;
    }
    client.number = next_client_++;
    clients_.push_back(std::move(client));
    Read(clients_.back());
    Write(clients_.back());
  }
}

void Server::Refuse(int fd) {
  constexpr std::string_view kWhy =
      R"({"id":null,"reason":"16 clients are connected already","result":"REJECTED"})"
      "\n";
  static_cast<void>(send(fd, kWhy.data(), kWhy.size(), MSG_NOSIGNAL));
  close(fd);
}

void Server::Read(Client& client) {
  std::array<char, kLongestLine> bytes{};
  for (int i = 0; i < kMaxReadsAtOnce && !client.ended; ++i) {
    const ssize_t size = recv(client.fd, bytes.data(), bytes.size(), 0);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
    client.ended = size <= 0;
    if (size > 0) client.input.append(bytes.data(), static_cast<std::size_t>(size));
    for (std::size_t end = 0; !client.ended && (end = client.input.find('\n')) <= kLongestLine;) {
      const std::string line = client.input.substr(0, end);
      client.input.erase(0, end + 1);
      if (!line.empty()) TakeLine(client, line);
    }
    // What comes before the end of the connection is a line, too, without its end.
    if (size == 0 && !client.input.empty() && client.input.size() <= kLongestLine)
      TakeLine(client, std::exchange(client.input, {}));
    if (client.input.size() > kLongestLine) {
      Reply(client, "null", Rejected("a request is one line of at most 4096 bytes"));
      client.ended = true;
    }
  }
}

void Server::TakeLine(Client& client, std::string_view line) {
  RequestLine request = Understand(line, permissions_);
  if (const Json* answer = std::get_if<Json>(&request.asks)) {
    Reply(client, request.id, *answer);
  } else if (const Question* question = std::get_if<Question>(&request.asks)) {
    Reply(client, request.id, AnswerTo(*question));
  } else if (Subscription* subscription = std::get_if<Subscription>(&request.asks)) {
    Subscribe(client, std::move(request.id), std::move(*subscription));
  } else {
    Ask(client, request);
  }
}

int Server::PollTimeoutMs() const noexcept {
  constexpr int kAnswerMs = 1;    // while the simulation is to answer
  constexpr int kSamplesMs = 10;  // for a hundredth of the samples that there is room for
  constexpr int kIdleMs = 100;
  if (!asked_.empty()) return kAnswerMs;
  const bool any = std::any_of(clients_.begin(), clients_.end(),
                               [](const Client& client) { return client.subscription.every_ticks != 0; });
  return any ? kSamplesMs : kIdleMs;
}

void Server::Subscribe(Client& client, std::string id, Subscription subscription) {
  Reply(client, id, {{"result", "OK"}, {"tick", now_->sample.tick}});
  client.subscription = std::move(subscription);
  client.subscription_id = std::move(id);
  client.sampled_tick = 0;
  client.dropped_samples = 0;
  ChooseSamples();
}

/// The simulation gives the samples that anybody wants.
void Server::ChooseSamples() {
  std::uint64_t every = 0;
  for (const Client& client : clients_) every = std::gcd(every, client.subscription.every_ticks);
  emulator_.SampleEvery(every);
}

void Server::PassSamplesOn() {
  simulation::RunState sample;
  while (emulator_.TryPopSample(sample)) {
    for (Client& client : clients_) {
      const std::uint64_t every = client.subscription.every_ticks;
      if (every != 0 && sample.sample.tick % every == 0) PassOn(sample, client);
    }
  }
}

/// A sample that finds no room is dropped; the next one tells how many were.
void Server::PassOn(const simulation::RunState& sample, Client& client) {
  if (client.ended || client.output.size() > kMaxSamples) return;
  const std::uint64_t tick = sample.sample.tick;
  const std::uint64_t every = client.subscription.every_ticks;
  if (client.sampled_tick != 0) client.dropped_samples += (tick - client.sampled_tick) / every - 1;
  client.sampled_tick = tick;
  client.output += SampleLine(client.subscription_id, client.subscription, sample, client.dropped_samples);
}

Json Server::AnswerTo(Question question) {
  emulator_.TakeNewest(*now_);
  emulator_.TakeFaults(faults_);
  switch (question) {
    case Question::kStatus: {
      Json status = StatusToJson(*now_);
      status["stroke_in"] = permissions_.faults.surroundings.unfaulted->servo.stroke_in;
      status["buses"] = BusesToJson(buses_);
      status["saturated"] = SaturatedToJson(emulator_);
      return status;
    }
    case Question::kStatistics: {
      Json answer = {{"result", "OK"}, {"statistics", statistics_()}};
      return answer;
    }
    case Question::kFaults:
      return FaultsToJson(faults_, now_->sample.tick, permissions_.faults);
    default:
      return CatalogueToJson(permissions_.faults.surroundings);
  }
}

void Server::Ask(Client& client, const RequestLine& line) {
  simulation::Request request = std::get<simulation::Request>(line.asks);
  request.number = next_request_++;
  if (asked_.size() < kMaxAsked && emulator_.PutRequest(request)) {
    asked_.push_back({request.number, client.number, line.id, line.warning});
  } else {
    Reply(client, line.id, Rejected("too many requests wait already"));
  }
}

void Server::TakeAnswers() {
  simulation::Answer answer;
  while (emulator_.TryPopAnswer(answer)) {
    if (answer.number == 0) continue;  // asked by this program itself
    // They come in the order of the requests; one whose client has gone is not waited for.
    while (!asked_.empty() && asked_.front().request != answer.number) asked_.pop_front();
    if (asked_.empty()) continue;
    const Asked asked = asked_.front();
    asked_.pop_front();
    const auto client = std::find_if(clients_.begin(), clients_.end(),
                                     [&](const Client& c) { return c.number == asked.client; });
    if (client == clients_.end()) continue;
    Json json = ToJson(answer);
    if (!asked.warning.empty() && answer.result == simulation::Answer::Result::kApplied)
      json["warning"] = asked.warning;
    Reply(*client, asked.id, json);
  }
}

/// One that has ended its requests, but may still read: `printf ... | nc -N`.
bool Server::IsOwed(const Client& client) const {
  return std::any_of(asked_.begin(), asked_.end(),
                     [&](const Asked& asked) { return asked.client == client.number; });
}

void Server::Reply(Client& client, const std::string& id, const Json& answer) {
  const std::string text = AnswerLine(id, answer);
  if (client.output.size() + text.size() > kMaxOutput) {  // does not read
    client.lost = true;
    return;
  }
  client.output += text;
}

void Server::Write(Client& client) {
  while (!client.output.empty()) {
    const ssize_t size = send(client.fd, client.output.data(), client.output.size(), MSG_NOSIGNAL);
    if (size > 0) {
      client.output.erase(0, static_cast<std::size_t>(size));
      continue;
    }
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
    client.lost = true;
    return;
  }
}

std::filesystem::path DefaultSocket() {
  const std::filesystem::path system = "/run/servohil";
  if (access(system.c_str(), W_OK) == 0) return system / "servohil.sock";
  if (const char* directory = std::getenv("XDG_RUNTIME_DIR"); directory != nullptr && *directory != 0)
    return std::filesystem::path(directory) / "servohil.sock";
  return "/tmp/servohil-" + std::to_string(getuid()) + ".sock";
}

}  // namespace servohil::control
