#include "recording/reader.hpp"

#include <algorithm>
#include <optional>
#include <sstream>
#include <type_traits>
#include <variant>

#include "base/error.hpp"
#include "base/readable.hpp"
#include "recording/hdf5.hpp"
#include "recording/recording_format.hpp"
#include "recording/sample_columns.hpp"
#include "recording/stimulus_columns.hpp"

namespace servohil::recording {
namespace {

Id OpenFile(const std::string& name) {
  base::RequireReadable(name);
  if (H5Fis_hdf5(name.c_str()) <= 0) throw base::UsageError(name + ": is no HDF5 file");
  // A reader's mode: takes a file that is being written, and one whose writer was killed. What its writer is
  // just changing is read again, each time after twice the pause, the first of 1 ns: for up to 0.3 s. Damage
  // looks the same.
  constexpr unsigned kAttempts = 28;
  const Id access(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_metadata_read_attempts(*access, kAttempts);
  Id file(H5Fopen(name.c_str(), H5F_ACC_RDONLY | H5F_ACC_SWMR_READ, *access));
  if (!file) throw base::UsageError(name + ": cannot be opened: " + LastError());
  if (!HasAttribute(*file, attribute::kFormat))
    throw base::UsageError(name + ": is no recording of servohil");
  const std::uint64_t format = ReadNumber(*file, attribute::kFormat, name);
  if (format < kOldestRecordingFormat || format > kRecordingFormat) {
    throw base::UsageError(name + ": is a recording of format " + std::to_string(format) + ", expected " +
                           std::to_string(kOldestRecordingFormat) + " to " +
                           std::to_string(kRecordingFormat) + ": replay it with the version that wrote it");
  }
  return file;
}

template <typename T>
hid_t MemoryType() {
  if constexpr (std::is_same_v<T, double>) return H5T_NATIVE_DOUBLE;
  if constexpr (std::is_same_v<T, std::uint64_t>) return H5T_NATIVE_UINT64;
  if constexpr (std::is_same_v<T, std::int64_t>) return H5T_NATIVE_INT64;
  if constexpr (std::is_same_v<T, int>) return H5T_NATIVE_INT32;
  if constexpr (std::is_same_v<T, std::uint8_t>) return H5T_NATIVE_UINT8;
}

/// One dataset of a group.
class Column {
 public:
  Column(hid_t file, const std::string& name, const std::string& file_name)
      : place_(file_name + ": " + name), dataset_(Open(file, name)) {
    const Id space(H5Dget_space(*dataset_));
    hsize_t rows = 0;
    if (H5Sget_simple_extent_ndims(*space) != 1 || H5Sget_simple_extent_dims(*space, &rows, nullptr) < 0)
      throw base::UsageError(place_ + ": is no column");
    rows_ = rows;
    const Id properties(H5Dget_create_plist(*dataset_));
    hsize_t chunk = 0;
    if (H5Pget_layout(*properties) == H5D_CHUNKED && H5Pget_chunk(*properties, 1, &chunk) == 1 && chunk > 0)
      chunk_rows_ = chunk;
    CheckChunks();
  }

  std::uint64_t Rows() const noexcept { return rows_; }

  /// @pre first + values.size() <= Rows()
  template <typename T>
  void Read(std::uint64_t first, std::vector<T>& values) const {
    if (values.empty() || WhyNotRead(first, values.size(), values.data()).empty()) return;
    // Which chunk: one after the other.
    const std::uint64_t end = first + values.size();
    for (std::uint64_t row = first; row < end;) {
      const std::uint64_t chunk = row / chunk_rows_ * chunk_rows_;
      const std::uint64_t next = std::min(end, chunk + chunk_rows_);
      const std::string why = WhyNotRead(row, next - row, values.data());
      if (!why.empty()) {
        throw base::UsageError(place_ + ": rows " + std::to_string(chunk) + " to " +
                               std::to_string(std::min(rows_, chunk + chunk_rows_) - 1) +
                               " are damaged: " + why);
      }
      row = next;
    }
    throw base::UsageError(place_ + ": cannot be read");
  }

 private:
  Id Open(hid_t file, const std::string& name) const {
    Id dataset(H5Dopen2(file, name.c_str(), H5P_DEFAULT));
    if (dataset) return dataset;
    const std::string why = LastError();
    const bool there = H5Lexists(file, name.substr(0, name.find('/')).c_str(), H5P_DEFAULT) > 0 &&
                       H5Lexists(file, name.c_str(), H5P_DEFAULT) > 0;
    throw base::UsageError(place_ + (there ? ": cannot be opened: " + why : std::string(": is missing")));
  }
  /// A chunk that is not there would read as zeros. At the end of the column, its rows are as good as not
  /// written.
  void CheckChunks() {
    const Id space(H5Dget_space(*dataset_));
    hsize_t there = 0;
    if (H5Dget_num_chunks(*dataset_, *space, &there) < 0)
      throw base::UsageError(place_ + ": cannot be read: " + LastError());
    while (rows_ > 0 && !HasChunkOf(rows_ - 1)) rows_ = (rows_ - 1) / chunk_rows_ * chunk_rows_;
    const std::uint64_t expected = (rows_ + chunk_rows_ - 1) / chunk_rows_;
    if (there < expected)
      throw base::UsageError(place_ + ": " + std::to_string(expected - there) + " of " +
                             std::to_string(expected) + " chunks are missing");
  }
  bool HasChunkOf(hsize_t row) const {
    unsigned filters = 0;
    haddr_t address = HADDR_UNDEF;
    hsize_t size_bytes = 0;
    return H5Dget_chunk_info_by_coord(*dataset_, &row, &filters, &address, &size_bytes) >= 0 &&
           address != HADDR_UNDEF;
  }
  /// Empty when read. The reason is asked for at once: the next call of the library, closing included,
  /// forgets it.
  template <typename T>
  std::string WhyNotRead(hsize_t first, hsize_t count, T* values) const {
    const Id from(H5Dget_space(*dataset_));
    const Id to(H5Screate_simple(1, &count, nullptr));
    const bool read = H5Sselect_hyperslab(*from, H5S_SELECT_SET, &first, nullptr, &count, nullptr) >= 0 &&
                      H5Dread(*dataset_, MemoryType<T>(), *to, *from, H5P_DEFAULT, values) >= 0;
    return read ? std::string() : LastError();
  }

  std::string place_;
  Id dataset_;
  std::uint64_t rows_ = 0;
  std::uint64_t chunk_rows_ = 1;
};

template <typename T>
std::vector<T> ReadAll(const Column& column, std::uint64_t rows) {
  std::vector<T> values(static_cast<std::size_t>(rows));
  column.Read(0, values);
  return values;
}

RecordingAttributes ReadAttributes(hid_t file, const std::string& name) {
  RecordingAttributes a;
  a.configuration_toml = ReadText(file, attribute::kConfiguration, name);
  a.dbc = {ReadText(file, attribute::kDbc, name)};
  while (HasAttribute(file, attribute::Dbc(a.dbc.size()).c_str()))
    a.dbc.push_back(ReadText(file, attribute::Dbc(a.dbc.size()).c_str(), name));
  a.load_csv = ReadText(file, attribute::kLoad, name);
  a.load_closing_csv = ReadText(file, attribute::kLoadClosing, name);
  a.start_snapshot = ReadText(file, attribute::kStartSnapshot, name);
  a.program_version = ReadText(file, attribute::kProgramVersion, name);
  a.clock = ReadText(file, attribute::kClock, name);
  std::istringstream buses(ReadText(file, attribute::kBuses, name));
  for (std::string bus; buses >> bus;) a.buses.push_back(bus);
  a.every_ticks = ReadNumber(file, attribute::kEveryTicks, name);
  a.host = ReadText(file, attribute::kHost, name);
  a.start_time = ReadText(file, attribute::kStartTime, name);
  a.configuration_fnv1a_64 = ReadText(file, attribute::kHash, name);
  if (const std::string hash = base::HashText(configuration::ConfigurationHash(a));
      hash != a.configuration_fnv1a_64) {
    throw base::UsageError(name + ": configuration, DBC or load table are damaged: their hash is " + hash +
                           ", recorded as " + a.configuration_fnv1a_64);
  }
  return a;
}

}  // namespace

struct RecordingReader::Contents {
  explicit Contents(const std::filesystem::path& path)
      : file_path(base::IsDirectory(path) ? path / kRecordingFile : path),
        name(file_path.string()),
        file(OpenFile(name)),
        attributes(ReadAttributes(*file, name)) {
    for (const SampleColumn& column : SampleColumns()) {
      const std::string path_in_file = std::string("samples/") + column.name;
      auto& place = samples.emplace_back();
      if (column.required || Has(path_in_file)) place.emplace(*file, path_in_file, name);
    }
    sample_count = samples.front()->Rows();
    for (const auto& column : samples) {
      if (column) sample_count = std::min(sample_count, column->Rows());
    }
    if (HasAttribute(*file, attribute::kComplete)) {
      complete = ReadNumber(*file, attribute::kComplete, name) != 0;
    }
    if (HasAttribute(*file, attribute::kVerdict)) {
      end = RecordingEnd{ReadText(*file, attribute::kVerdict, name),
                         ReadNumber(*file, attribute::kFinalStateHash, name)};
      if (HasAttribute(*file, attribute::kFinalTick))
        end->final_tick = ReadNumber(*file, attribute::kFinalTick, name);
    }
  }

  Column Open(const char* column) const { return {*file, column, name}; }
  /// @pre its group is there
  bool Has(const std::string& column) const { return H5Lexists(*file, column.c_str(), H5P_DEFAULT) > 0; }

  std::filesystem::path file_path;
  std::string name;
  Id file;
  RecordingAttributes attributes;
  std::vector<std::optional<Column>> samples;  ///< in the order of SampleColumns()
  std::uint64_t sample_count = 0;
  std::optional<RecordingEnd> end;
  bool complete = false;
};

RecordingReader::RecordingReader(const std::filesystem::path& path) {
  PrepareThread();
  contents_ = std::make_unique<Contents>(path);
}

RecordingReader::~RecordingReader() = default;

const std::filesystem::path& RecordingReader::File() const noexcept {
  return contents_->file_path;
}
const RecordingAttributes& RecordingReader::Attributes() const noexcept {
  return contents_->attributes;
}
const std::optional<RecordingEnd>& RecordingReader::End() const noexcept {
  return contents_->end;
}
bool RecordingReader::Complete() const noexcept {
  return contents_->complete && contents_->end;
}
std::uint64_t RecordingReader::SampleCount() const noexcept {
  return contents_->sample_count;
}

bool RecordingReader::HasColumn(std::size_t column) const noexcept {
  return contents_->samples[column].has_value();
}

std::size_t RecordingReader::ReadSamples(std::uint64_t first, std::span<simulation::RunState> samples) const {
  if (first >= contents_->sample_count) return 0;
  const auto count =
      static_cast<std::size_t>(std::min<std::uint64_t>(samples.size(), contents_->sample_count - first));
  const auto columns = SampleColumns();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    std::visit(
        [&](auto place) {
          using Value = std::remove_reference_t<decltype(place(samples[0]))>;
          std::vector<Stored<Value>> values(count);
          if (!contents_->samples[i]) return;
          contents_->samples[i]->Read(first, values);
          for (std::size_t row = 0; row < count; ++row) place(samples[row]) = static_cast<Value>(values[row]);
        },
        columns[i].place);
  }
  return count;
}

std::vector<Stimulus> RecordingReader::Stimuli() const {
  std::vector<Stimulus> stimuli;
  const std::string group = "influences/";
  // What all its columns have: a killed recording's may differ by the last rows.
  std::uint64_t rows = contents_->Open((group + StimulusColumns().front().name).c_str()).Rows();
  for (const StimulusColumn& place : StimulusColumns()) {
    const std::string column_name = group + place.name;
    if (!place.required && !contents_->Has(column_name)) continue;
    const Column column = contents_->Open(column_name.c_str());
    rows = std::min(rows, column.Rows());
    stimuli.resize(static_cast<std::size_t>(rows));
    std::visit(
        [&](auto value) {
          using Value = std::remove_reference_t<std::invoke_result_t<decltype(value), Stimulus&>>;
          const auto stored = ReadAll<StoredInfluence<Value>>(column, rows);
          for (std::size_t i = 0; i < stored.size(); ++i) value(stimuli[i]) = static_cast<Value>(stored[i]);
        },
        place.place);
  }
  return stimuli;
}

std::vector<RecordingGap> RecordingReader::Gaps() const {
  const Column stream = contents_->Open("gaps/stream");
  const Column tick = contents_->Open("gaps/tick");
  const Column lost = contents_->Open("gaps/lost");
  const std::uint64_t rows = std::min({stream.Rows(), tick.Rows(), lost.Rows()});
  const auto streams = ReadAll<std::uint8_t>(stream, rows);
  const auto ticks = ReadAll<std::uint64_t>(tick, rows);
  const auto losses = ReadAll<std::uint64_t>(lost, rows);
  std::vector<RecordingGap> gaps;
  for (std::size_t i = 0; i < ticks.size(); ++i)
    gaps.push_back({static_cast<RecordedStream>(streams[i]), ticks[i], losses[i]});
  return gaps;
}

}  // namespace servohil::recording
