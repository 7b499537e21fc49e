// Any bytes as a file that a user hands over: read, or refused with one line. The first byte says what it is.

#include <array>
#include <cmath>

#include "configuration/load_file.hpp"
#include "fuzz.hpp"
#include "memory_file.hpp"
#include "run/candump.hpp"
#include "run/p1_script.hpp"
#include "run/snapshot_file.hpp"

namespace {

void ReadCandump(const std::string& file) {
  constexpr int kLargest = 64;
  for (const auto& [frame, interface, line] : servohil::run::ReadCandump(file)) {
    Require(frame.receive_time_ns >= 0, "no frame is older than the epoch");
    Require(frame.id <= (frame.extended ? 0x1FFF'FFFFU : 0x7FFU), "an identifier fits its format");
    Require(frame.size <= (frame.fd ? kLargest : 8), "a frame has its size");
  }
}

void ReadP1Script(const std::string& file) {
  std::uint64_t last = 0;
  for (const servohil::recording::Stimulus& stimulus : servohil::run::ReadP1Script(file)) {
    Require(stimulus.tick >= last && stimulus.tick > 0, "P1 changes in the order of time");
    Require(std::isfinite(stimulus.request.p1_psi), "P1 is a number");
    last = stimulus.tick;
  }
}

void ReadLoadCurve(const std::string& file) {
  Require(servohil::configuration::ReadLoadCurve(file).size() >= 2, "a curve has two points");
}

void ReadSnapshot(const std::string& file) {
  servohil::run::ReadSnapshot(file);
}

/// The state alone, which no checksum guards; what is read comes back as it went.
void ParseState(std::string_view text) {
  const servohil::emulator::Snapshot snapshot = servohil::run::ParseSnapshotText(std::string(text), "fuzz");
  const std::string again = servohil::run::SnapshotText(snapshot);
  Require(servohil::run::SnapshotText(servohil::run::ParseSnapshotText(again, "fuzz")) == again,
          "a state comes back as it went");
}

}  // namespace

int FuzzOne(std::string_view bytes) {
  static const MemoryFile file;
  constexpr std::array kReaders = {ReadCandump, ReadP1Script, ReadLoadCurve, ReadSnapshot};
  if (bytes.empty()) return -1;
  const std::size_t kind = static_cast<unsigned char>(bytes.front()) % (kReaders.size() + 1);
  bytes.remove_prefix(1);
  RequireReadableErrors([&] {
    if (kind == kReaders.size()) return ParseState(bytes);
    kReaders[kind](file.With(bytes));
  });
  return 0;
}
