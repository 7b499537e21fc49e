#include "recording/recording_file.hpp"

#include <sys/utsname.h>

#include <algorithm>
#include <ctime>
#include <type_traits>
#include <utility>
#include <variant>

#include "base/clock.hpp"
#include "base/error.hpp"
#include "base/formatted.hpp"
#include "can/dbc/codec.hpp"
#include "fault/catalogue.hpp"
#include "model/step.hpp"
#include "recording/recording_format.hpp"
#include "recording/sample_columns.hpp"
#include "recording/stimulus_columns.hpp"

namespace servohil::recording {
namespace {

/// A row waits this long for its chunk to fill, and the file then this long for its flush: 0.7 s of the one
/// second that a kill may cost.
constexpr std::int64_t kRowWaitNs = 500 * base::kNsPerMs;
constexpr std::int64_t kFlushEveryNs = 200 * base::kNsPerMs;
/// Rows of a chunk: those of 0.41 s in real time, so that a chunk fills before its rows have waited too long
/// and is packed once.
constexpr std::uint64_t kTicksPerChunk = 4'096;
constexpr std::uint64_t kSmallestChunkRows = 16;
constexpr std::size_t kInfluencesPerChunk = 64;

std::size_t ChunkRows(std::uint64_t ticks_per_row) {
  return static_cast<std::size_t>(std::max(kSmallestChunkRows, kTicksPerChunk / ticks_per_row));
}

std::string UtcNow() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

std::string Host() {
  utsname name{};
  uname(&name);
  return std::string(name.sysname) + ' ' + name.nodename + ' ' + name.release + ' ' + name.machine;
}

std::string Joined(const std::vector<std::string>& items) {
  std::string text;
  for (const std::string& item : items) text += (text.empty() ? "" : " ") + item;
  return text;
}

/// A reader that looks at the file at the wrong moment locks it; the writer does not give way to it. A second
/// writer is kept out by H5F_ACC_EXCL.
Id AccessWithoutLock() {
  Id access(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_file_locking(*access, false, true);
  return access;
}

Id CreateFile(const std::string& name) {
  const Id access = AccessWithoutLock();
  H5Pset_libver_bounds(*access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  // The library keeps one chunk of a column, no more, so that little waits for the disk that may be full. Set
  // for the file: single-writer mode forgets what is set for a dataset.
  constexpr int kIgnored = 0;
  constexpr std::size_t kSlots = 3;
  constexpr std::size_t kChunkBytes = kTicksPerChunk * sizeof(double);
  constexpr double kEvictWritten = 1.0;
  H5Pset_cache(*access, kIgnored, kSlots, kChunkBytes, kEvictWritten);
  // Attributes of any size: not in the object header (64 KiB), but in a heap of their own.
  const Id creation(H5Pcreate(H5P_FILE_CREATE));
  H5Pset_attr_phase_change(*creation, 0, 0);
  return Require(Id(H5Fcreate(name.c_str(), H5F_ACC_EXCL, *creation, *access)), name + ": cannot be made");
}

/// "1 air_entrainment" for each fault of the catalogue, a line each: what the numbers on file mean.
std::string FaultNames() {
  std::string names;
  for (const fault::Spec& spec : fault::Catalogue())
    names += std::to_string(spec.id) + ' ' + spec.name + '\n';
  return names;
}

void WriteAttributes(hid_t file, const RecordingAttributes& a, const std::string& name) {
  WriteAttribute(file, attribute::kFormat, kRecordingFormat, name);
  WriteAttribute(file, attribute::kConfiguration, a.configuration_toml, name);
  for (std::size_t i = 0; i < a.dbc.size(); ++i)
    WriteAttribute(file, attribute::Dbc(i).c_str(), a.dbc[i], name);
  WriteAttribute(file, attribute::kLoad, a.load_csv, name);
  WriteAttribute(file, attribute::kLoadClosing, a.load_closing_csv, name);
  WriteAttribute(file, attribute::kHash, base::HashText(configuration::ConfigurationHash(a)), name);
  WriteAttribute(file, attribute::kStartSnapshot, a.start_snapshot, name);
  WriteAttribute(file, attribute::kProgramVersion, a.program_version, name);
  WriteAttribute(file, attribute::kClock, a.clock, name);
  WriteAttribute(file, attribute::kBuses, Joined(a.buses), name);
  WriteAttribute(file, attribute::kHost, Host(), name);
  WriteAttribute(file, attribute::kStartTime, UtcNow(), name);
  WriteAttribute(file, attribute::kTick, model::kTickS, name);
  WriteAttribute(file, attribute::kEveryTicks, a.every_ticks, name);
  WriteAttribute(file, attribute::kFaults, FaultNames(), name);
}

std::vector<TableColumn> SampleTableColumns() {
  std::vector<TableColumn> columns;
  for (const SampleColumn& column : SampleColumns()) {
    const auto type = std::visit(
        [](auto place) {
          return ColumnTypeOf<Stored<
              std::remove_reference_t<std::invoke_result_t<decltype(place), simulation::RunState&>>>>();
        },
        column.place);
    columns.push_back({column.name, column.unit, column.description, type,
                       column.compressible ? Packing::kDeflated : Packing::kAsIs});
  }
  return columns;
}

TableColumn TickColumn(const char* description) {
  return {"tick", "0.1 ms", description, TableColumn::Type::kUnsigned64};
}

std::vector<TableColumn> PublishedColumns(const can::Message& message) {
  std::vector<TableColumn> columns{TickColumn("whose state the frame carries")};
  for (const can::Signal& signal : message.signals)
    columns.push_back({signal.name, signal.unit, signal.comment});
  return columns;
}

std::vector<TableColumn> InfluenceTableColumns() {
  std::vector<TableColumn> columns;
  for (const StimulusColumn& column : StimulusColumns()) {
    const auto type = std::visit(
        [](auto place) {
          return ColumnTypeOf<
              StoredInfluence<std::remove_reference_t<std::invoke_result_t<decltype(place), Stimulus&>>>>();
        },
        column.place);
    columns.push_back({column.name, column.unit, column.description, type});
  }
  return columns;
}

std::vector<TableColumn> FaultEventColumns() {
  using Type = TableColumn::Type;
  return {TickColumn("the first that has something of it, or nothing any more"),
          {"kind", "", "0 waits, 1 starts, 2 ends, 3 changed, 4 cleared", Type::kByte},
          {"fault", "", "its number in the catalogue; `servohil fault list` has them", Type::kByte},
          {"target", "", "as in influences", Type::kByte},
          {"pulse", "", "starts, ends: how many there were before it", Type::kUnsigned64}};
}

}  // namespace

RecordingFile::RecordingFile(const std::filesystem::path& directory, const RecordingAttributes& attributes,
                             const signal_map::SignalMap& signal_map)
    : name_((directory / kRecordingFile).string()), buses_(attributes.buses), file_(CreateFile(name_)) {
  log_.emplace(directory / kBusLogFile);
  WriteAttributes(*file_, attributes, name_);
  CreateTables(signal_map, attributes.every_ticks);
  Require(H5Fstart_swmr_write(*file_), name_ + ": cannot be written");
}

void RecordingFile::CreateTables(const signal_map::SignalMap& signal_map, std::uint64_t every_ticks) {
  samples_.emplace(*file_, "samples", SampleTableColumns(), ChunkRows(every_ticks), name_);
  stimuli_.emplace(*file_, "influences", InfluenceTableColumns(), kInfluencesPerChunk, name_);
  fault_events_.emplace(*file_, "fault_events", FaultEventColumns(), kInfluencesPerChunk, name_);
  const std::vector<TableColumn> gap{
      {"stream", "", "0 samples, 1 influences, 2 received frames, 3 sent frames", TableColumn::Type::kByte},
      TickColumn("of the first one lost; of received frames about"),
      {"lost", "", "how many", TableColumn::Type::kUnsigned64}};
  gaps_.emplace(*file_, "gaps", gap, kSmallestChunkRows, name_);
  for (std::size_t i = 0; i < signal_map.MessageCount(); ++i) {
    const can::Message& message = signal_map.MessageOf(i);
    published_.push_back({message, TableWriter(*file_, "published/" + message.name, PublishedColumns(message),
                                               ChunkRows(signal_map.CycleTicks(i)), name_)});
  }
}

void RecordingFile::Add(const simulation::RunState& run_state, std::int64_t now_ns) {
  simulation::RunState copy = run_state;
  const auto columns = SampleColumns();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    std::visit(
        [&](auto place) {
          using Value = std::remove_reference_t<decltype(place(copy))>;
          samples_->Put(i, static_cast<Stored<Value>>(place(copy)));
        },
        columns[i].place);
  }
  samples_->EndRow(now_ns);
  if (samples_->ChunkIsFull()) WriteSamples();
}

void RecordingFile::WriteSamples() {
  stimuli_->Write();
  stimuli_->Flush();
  samples_->Write();
  flush_due_ = true;
}

void RecordingFile::Add(const Stimulus& stimulus, std::int64_t now_ns) {
  Stimulus copy = stimulus;
  const auto columns = StimulusColumns();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    std::visit(
        [&](auto place) {
          using Value = std::remove_reference_t<decltype(place(copy))>;
          stimuli_->Put(i, static_cast<StoredInfluence<Value>>(place(copy)));
        },
        columns[i].place);
  }
  EndRow(*stimuli_, now_ns);
}

void RecordingFile::Add(const fault::Event& event, std::int64_t now_ns) {
  fault_events_->Put(0, event.tick);
  fault_events_->Put(1, static_cast<std::uint8_t>(event.kind));
  fault_events_->Put(2, event.id);
  fault_events_->Put(3, event.target);
  fault_events_->Put(4, std::uint64_t{event.pulse});
  EndRow(*fault_events_, now_ns);
}

void RecordingFile::Add(const RecordingGap& gap, std::int64_t now_ns) {
  gaps_->Put(0, static_cast<std::uint8_t>(gap.stream));
  gaps_->Put(1, gap.tick);
  gaps_->Put(2, gap.lost);
  EndRow(*gaps_, now_ns);
}

void RecordingFile::AddPublished(std::uint64_t tick, std::size_t message, const can::Frame& frame,
                                 std::int64_t now_ns) {
  auto& published = published_[message];
  if (frame.size < published.message.size_bytes) return;
  published.table.Put(0, tick);
  std::size_t column = 1;
  const std::span<const std::uint8_t> data(frame.data.data(), frame.size);
  for (const can::Signal& signal : published.message.signals) {
    published.table.Put(column++, can::Carries(published.message, signal, data)
                                      ? can::Decode(signal, data)
                                      : std::numeric_limits<double>::quiet_NaN());
  }
  EndRow(published.table, now_ns);
}

void RecordingFile::EndRow(TableWriter& table, std::int64_t now_ns) {
  table.EndRow(now_ns);
  if (!table.ChunkIsFull()) return;
  table.Write();
  flush_due_ = true;
}

void RecordingFile::AddToLog(std::int64_t time_ns, std::optional<std::size_t> bus, const can::Frame& frame) {
  for (std::size_t i = 0; i < buses_.size(); ++i) {
    if (!bus || *bus == i) log_->Add(time_ns, buses_[i], frame);
  }
  ++pending_frames_;
}

void RecordingFile::Write(std::int64_t now_ns, bool all) {
  const auto due = [&](const TableWriter& table) {
    return all ? table.HasPendingRows() : table.HasRowsOlderThan(kRowWaitNs, now_ns);
  };
  for (TableWriter* table : OtherTables()) {
    if (!due(*table)) continue;
    table->Write();
    flush_due_ = true;
  }
  if (due(*samples_)) WriteSamples();
  if (!all && now_ns - flushed_ns_ < kFlushEveryNs) return;
  flushed_ns_ = now_ns;
  log_->Flush();
  frames_ += std::exchange(pending_frames_, 0);
  if (!flush_due_) return;
  // Table by table: H5Fflush alone would go on after an error, and leave rows whose data never came.
  for (TableWriter* table : OtherTables()) table->Flush();
  samples_->Flush();
  Require(H5Fflush(*file_, H5F_SCOPE_LOCAL), name_ + ": cannot be written");
  flush_due_ = false;
}

std::vector<TableWriter*> RecordingFile::OtherTables() {
  std::vector<TableWriter*> tables{&*stimuli_, &*fault_events_, &*gaps_};
  for (auto& published : published_) tables.push_back(&published.table);
  return tables;
}

void RecordingFile::Abandon() noexcept {
  for (TableWriter* table : OtherTables()) table->Abandon();
  samples_->Abandon();
  file_.Abandon();
}

void RecordingFile::Close(const std::optional<RecordingEnd>& end, const RecordingReport& report) {
  published_.clear();
  samples_.reset();
  stimuli_.reset();
  fault_events_.reset();
  gaps_.reset();
  log_.reset();
  if (!file_.Close()) throw base::EnvironmentError(name_ + ": cannot be closed: " + LastError());
  const Id file = Require(Id(H5Fopen(name_.c_str(), H5F_ACC_RDWR, *AccessWithoutLock())),
                          name_ + ": the end cannot be written");
  if (end) {
    WriteAttribute(*file, attribute::kVerdict, end->verdict, name_);
    WriteAttribute(*file, attribute::kFinalStateHash, end->final_state_hash, name_);
    WriteAttribute(*file, attribute::kFinalTick, end->final_tick, name_);
  }
  WriteAttribute(*file, attribute::kEndTime, UtcNow(), name_);
  WriteAttribute(*file, attribute::kSamplesLost, report.samples_lost, name_);
  WriteAttribute(*file, attribute::kInfluencesLost, report.stimuli_lost, name_);
  WriteAttribute(*file, attribute::kFramesLost, report.frames_lost, name_);
  WriteAttribute(*file, attribute::kProblem, report.problem, name_);
  WriteAttribute(*file, attribute::kComplete, std::uint64_t{report.complete ? 1U : 0U}, name_);
}

}  // namespace servohil::recording
