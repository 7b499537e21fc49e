#pragma once
/// The control socket: a Unix stream socket with JSON lines, for operators' commands and pipelines.
/// PROTOCOL.md has the protocol. Served by the thread that watches the run; no client, however slow, silent
/// or malicious, delays the loop or lets memory grow: lines, answers and clients are bounded.

#include <poll.h>

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "can/bus_monitor.hpp"
#include "control/requests.hpp"
#include "emulator/emulator.hpp"
#include "simulation/run_state.hpp"

namespace servohil::control {

class Server {
 public:
  /// Binds `path`, mode 0660, group servohil where there is one. A socket that a killed run has left is
  /// replaced. @param emulator must outlive it
  /// @throws EnvironmentError when another run has it, or it cannot be made
  Server(std::filesystem::path path, emulator::Emulator& emulator, fault_words::Permissions permissions);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  const std::filesystem::path& Path() const noexcept { return path_; }
  /// The descriptors to poll.
  void AddTo(std::vector<pollfd>& descriptors) const;
  /// After how long to look again when nothing comes [ms].
  int PollTimeoutMs() const noexcept;
  /// What answers `statistics`. @param ask  must not outlive what it refers to
  void AnswerStatisticsBy(std::function<nlohmann::json()> ask) { statistics_ = std::move(ask); }
  /// From now on.
  void Permit(fault_words::Permissions permissions) { permissions_ = std::move(permissions); }
  /// Takes and answers what there is. Never blocks. @param now  the newest state, made newer where somebody
  /// asks: an answer is never older than its question @param buses  of the buses
  void Serve(simulation::RunState& now, const std::vector<can::BusReport>& buses);

 private:
  struct Client {
    int fd = -1;
    std::uint64_t number = 0;
    std::string input;
    std::string output;
    bool ended = false;  ///< sends nothing more; closed when all its answers are out
    bool lost = false;   ///< does not read, or is gone: closed at once
    Subscription subscription;
    std::string subscription_id;     ///< as JSON
    std::uint64_t sampled_tick = 0;  ///< of the newest sample that went to it
    std::uint64_t dropped_samples = 0;
  };
  /// A request that the simulation has not answered yet.
  struct Asked {
    std::uint64_t request = 0;
    std::uint64_t client = 0;
    std::string id;  ///< as JSON
    std::string warning;
  };

  void ServeClients();
  void AcceptPendingClients();
  static void Refuse(int fd);
  void Read(Client& client);
  void TakeLine(Client& client, std::string_view line);
  nlohmann::json AnswerTo(Question question);
  void Ask(Client& client, const RequestLine& line);
  void TakeAnswers();
  void Subscribe(Client& client, std::string id, Subscription subscription);
  void ChooseSamples();
  void PassSamplesOn();
  static void PassOn(const simulation::RunState& sample, Client& client);
  bool IsOwed(const Client& client) const;
  static void Reply(Client& client, const std::string& id, const nlohmann::json& answer);
  static void Write(Client& client);

  std::filesystem::path path_;
  emulator::Emulator& emulator_;
  fault_words::Permissions permissions_;
  int fd_ = -1;
  std::list<Client> clients_;
  std::deque<Asked> asked_;
  std::uint64_t next_request_ = 1;
  std::uint64_t next_client_ = 1;
  simulation::RunState* now_ = nullptr;  ///< while it serves
  std::vector<can::BusReport> buses_;
  fault::Schedule faults_;
  std::function<nlohmann::json()> statistics_ = [] { return nlohmann::json::object(); };
};

/// Where `servohil run` and `servohil fault` meet without being told: /run/servohil/servohil.sock if that
/// directory is writable, else in $XDG_RUNTIME_DIR, else /tmp/servohil-UID.sock.
std::filesystem::path DefaultSocket();

}  // namespace servohil::control
