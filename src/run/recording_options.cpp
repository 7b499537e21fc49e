#include "run/recording_options.hpp"

#include "base/formatted.hpp"
#include "run/snapshot_file.hpp"

namespace servohil::run {

std::unique_ptr<recording::Recorder> RecordingOptions::Open(const configuration::RunTexts& texts,
                                                            const signal_map::SignalMap& signal_map,
                                                            const std::string& clock,
                                                            const std::optional<emulator::Snapshot>& from,
                                                            const std::vector<std::string>& buses) const {
  if (directory.empty()) return nullptr;
  recording::RecordingAttributes attributes;
  static_cast<configuration::RunTexts&>(attributes) = texts;
  attributes.program_version = SERVOHIL_VERSION;
  attributes.clock = clock;
  attributes.every_ticks = static_cast<std::uint64_t>(every_ticks);
  attributes.buses = buses;
  if (from) attributes.start_snapshot = SnapshotText(*from);
  recording::RecorderOptions options;
  options.producers_wait = clock != "real time";
  return std::make_unique<recording::Recorder>(directory, attributes, signal_map, options);
}

std::string FinishRecording(recording::Recorder* recorder, const std::filesystem::path& directory,
                            const simulation::RunState& end, const std::string& verdict) {
  if (recorder == nullptr) return {};
  const recording::RecordingReport report =
      recorder->Finish({verdict, end.sample.state_hash, end.sample.tick});
  return base::Formatted("recorded %llu samples, %llu influences, %llu frames in ",
                         static_cast<unsigned long long>(report.samples),
                         static_cast<unsigned long long>(report.stimuli),
                         static_cast<unsigned long long>(report.frames)) +
         directory.string() + (report.complete ? "; complete\n" : "; INCOMPLETE: " + report.problem + "\n");
}

}  // namespace servohil::run
