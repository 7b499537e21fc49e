#include "run/log_replay.hpp"

#include <cmath>
#include <map>
#include <utility>

#include "base/error.hpp"
#include "base/formatted.hpp"
#include "model/ticks.hpp"

namespace servohil::run {
namespace {

constexpr std::int64_t kDisorderNs = 10'000'000;
constexpr std::int64_t kLongestGapNs = 60'000'000'000;

using Count = unsigned long long;  // for printf

/// "can0 (600 frames), can1 (2 frames)"
std::string Listed(const std::map<std::string, Count>& interfaces) {
  std::string text;
  for (const auto& [name, count] : interfaces)
    text += (text.empty() ? "" : ", ") + name + base::Formatted(" (%llu frames)", count);
  return text;
}

std::string Place(const std::filesystem::path& file, const LoggedFrame& frame) {
  return file.string() + ":" + std::to_string(frame.line) + ": ";
}

}  // namespace

std::vector<LoggedFrame> FramesOfInterface(std::vector<LoggedFrame> frames, const std::string& wanted,
                                           const signal_map::SignalMap& signal_map,
                                           const std::filesystem::path& file) {
  std::map<std::string, Count> all;
  std::map<std::string, Count> governors;
  for (const LoggedFrame& one : frames) {
    ++all[one.interface];
    if (signal_map.FindIncoming(one.frame) != nullptr) ++governors[one.interface];
  }
  std::string chosen = wanted;
  if (chosen.empty() && governors.size() > 1) {
    throw base::UsageError(file.string() + ": messages of the governor come from several interfaces: " +
                           Listed(governors) + "; choose one with --interface");
  }
  if (chosen.empty()) chosen = governors.empty() ? frames.front().interface : governors.begin()->first;
  if (!all.contains(chosen)) {
    throw base::UsageError(file.string() + ": there is no frame of interface " + chosen + "; there are " +
                           Listed(all));
  }
  std::erase_if(frames, [&](const LoggedFrame& one) { return one.interface != chosen; });
  return frames;
}

std::vector<FrameAfter> OnTimeLine(std::span<const LoggedFrame> frames, const std::filesystem::path& file) {
  std::vector<FrameAfter> line;
  if (frames.empty()) return line;
  const std::int64_t start_ns = frames.front().frame.receive_time_ns;
  std::int64_t latest_ns = start_ns;
  for (const LoggedFrame& one : frames) {
    const std::int64_t step_ns = one.frame.receive_time_ns - latest_ns;
    const double step_s = static_cast<double>(step_ns) / 1e9;
    if (step_ns < -kDisorderNs) {
      throw base::UsageError(
          Place(file, one) +
          base::Formatted("time steps back by %.6f s: a time stamp before it is ahead, or the clock was "
                          "set; must rise (10 ms are granted)",
                          -step_s));
    }
    if (step_ns > kLongestGapNs) {
      throw base::UsageError(
          Place(file, one) +
          base::Formatted("time steps ahead by %.6f s: the clock was set, or nothing was logged; must be "
                          "at most 60 s, else split the log there",
                          step_s));
    }
    latest_ns = std::max(latest_ns, one.frame.receive_time_ns);
    const double ticks =
        std::round(static_cast<double>(latest_ns - start_ns) / static_cast<double>(model::kTickNs));
    line.push_back({static_cast<std::uint64_t>(ticks), one.frame});
  }
  return line;
}

std::string DescribeReceived(const emulator::ReceiveCounters& received) {
  std::string text =
      base::Formatted("%llu commands followed", Count{received.Of(simulation::FrameVerdict::kValid)});
  std::string refused;
  for (std::size_t i = 1; i < simulation::kFrameVerdicts; ++i) {
    if (const Count count = received.of[i].load(); count != 0)
      refused += (refused.empty() ? "" : ", ") +
                 base::Formatted("%llu %s", count, simulation::kFrameVerdictNames[i]);
  }
  if (!refused.empty()) text += "; refused: " + refused;
  if (const Count lost = received.lost.load(); lost != 0) text += base::Formatted("; %llu never came", lost);
  return text;
}

}  // namespace servohil::run
