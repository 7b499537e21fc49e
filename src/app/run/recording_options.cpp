#include "recording_options.hpp"

#include "formatted.hpp"
#include "snapshot_file.hpp"

namespace servohil::app {

std::unique_ptr<Recorder> RecordingOptions::Open(const RunTexts& texts, const Contract& contract,
                                                 const std::string& clock,
                                                 const std::optional<Snapshot>& from,
                                                 const std::vector<std::string>& buses) const {
  if (directory.empty()) return nullptr;
  RecordingAttributes attributes;
  static_cast<RunTexts&>(attributes) = texts;
  attributes.program_version = SERVOHIL_VERSION;
  attributes.clock = clock;
  attributes.every_ticks = static_cast<std::uint64_t>(every_ticks);
  attributes.buses = buses;
  if (from) attributes.start_snapshot = SnapshotText(*from);
  RecorderOptions options;
  options.producers_wait = clock != "real time";
  return std::make_unique<Recorder>(directory, attributes, contract, options);
}

std::string FinishRecording(Recorder* recorder, const std::filesystem::path& directory, const Telemetry& end,
                            const std::string& verdict) {
  if (recorder == nullptr) return {};
  const RecordingReport report = recorder->Finish({verdict, end.sample.state_hash});
  return Formatted("recorded %llu samples, %llu influences, %llu frames in ",
                   static_cast<unsigned long long>(report.samples),
                   static_cast<unsigned long long>(report.influences),
                   static_cast<unsigned long long>(report.frames)) +
         directory.string() + (report.complete ? "; complete\n" : "; INCOMPLETE: " + report.problem + "\n");
}

}  // namespace servohil::app
