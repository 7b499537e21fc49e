#include "recording/recorder.hpp"

#include <sys/statvfs.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <ctime>
#include <limits>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <variant>
#include <vector>

#include "base/clock.hpp"
#include "base/error.hpp"
#include "base/formatted.hpp"
#include "recording/lossy_ring.hpp"
#include "recording/recording_file.hpp"
#include "rt/process.hpp"

namespace servohil::recording {
namespace {

// 3 s: of samples at 10,000 a second, of frames on a bus of 500 kbit/s (at most 10,600 a second, of 47 bits).
constexpr std::size_t kSampleRing = 32'768;
constexpr std::size_t kFrameRing = 32'768;
constexpr auto kRoundEvery = std::chrono::milliseconds(10);
/// Of one round, so that the space on the disk is looked at often enough: with 2,048 frames in each direction
/// (40 to 180 bytes each) at most 2 MB.
constexpr int kSamplesPerRound = 4'096;
constexpr int kFramesPerRound = 2'048;
/// The two rings of frames are merged by time: a frame is written once none earlier can come.
constexpr std::int64_t kMergeWindowNs = 50'000'000;

double ThreadCpuS() noexcept {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

/// Nothing when there is room; else one line.
std::string LackOfSpace(const std::filesystem::path& directory, const RecorderOptions& options) {
  constexpr double kMegabyte = 1e6;
  const std::uint64_t free_bytes = options.free_bytes(directory);
  if (free_bytes >= options.reserve_bytes) return {};
  return directory.string() + base::Formatted(": disk full: %.1f MB left, recording ends below %.1f MB",
                                              static_cast<double>(free_bytes) / kMegabyte,
                                              static_cast<double>(options.reserve_bytes) / kMegabyte);
}

void MakeDirectory(const std::filesystem::path& directory, const RecorderOptions& options) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) throw base::EnvironmentError(directory.string() + ": cannot be made: " + error.message());
  for (const char* name : {kRecordingFile, kBusLogFile}) {
    if (std::filesystem::exists(directory / name, error)) {
      throw base::UsageError(directory.string() + ": holds a recording already (" + name +
                             "); name a directory without one");
    }
  }
  if (const std::string lack = LackOfSpace(directory, options); !lack.empty())
    throw base::EnvironmentError(lack);
}

struct LoggedFrame {
  can::Frame frame;
  std::int64_t time_ns = 0;
  std::uint64_t tick = 0;
  std::optional<std::size_t> bus;  ///< received on it; nothing: sent, on all
  std::size_t message = 0;         ///< sent
};

/// One stream, so that no sample is on file before what it has felt.
using FaultOrStimulus = std::variant<Stimulus, fault::Event>;

constexpr std::size_t kRecordedStreams = 4;
constexpr std::size_t Index(RecordedStream stream) {
  return static_cast<std::size_t>(stream);
}

}  // namespace

std::uint64_t FreeBytes(const std::filesystem::path& directory) {
  struct statvfs disk {};
  if (statvfs(directory.c_str(), &disk) != 0)
    throw base::EnvironmentError(directory.string() + ": " + std::generic_category().message(errno));
  return std::uint64_t{disk.f_bavail} * disk.f_frsize;
}

class Recorder::Writer {
 public:
  Writer(const std::filesystem::path& directory, const RecordingAttributes& attributes,
         const signal_map::SignalMap& signal_map, const RecorderOptions& options)
      : directory_(directory),
        options_(options),
        every_ticks_(attributes.every_ticks),
        file_(directory, attributes, signal_map),
        thread_([this] { Run(); }) {}
  ~Writer() { Finish(std::nullopt); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  void RecordTick(const simulation::RunState& run_state) noexcept {
    const std::uint64_t tick = run_state.sample.tick;
    newest_tick_.store(tick, std::memory_order_relaxed);
    if (tick % every_ticks_ == 0) Push(samples_, tick, run_state);
  }
  void RecordStimulus(const Stimulus& stimulus) noexcept { Push(stimuli_, stimulus.tick, stimulus); }
  void RecordFaultEvent(const fault::Event& event) noexcept { Push(stimuli_, event.tick, event); }
  void RecordReceived(const can::Frame& frame, std::size_t bus) noexcept {
    const std::int64_t time_ns = frame.receive_time_ns != 0 ? frame.receive_time_ns : base::RealTimeNs();
    const std::uint64_t tick = newest_tick_.load(std::memory_order_relaxed);
    Push(received_, tick, LoggedFrame{frame, time_ns, tick, bus, 0});
  }
  void RecordSent(std::uint64_t tick, std::size_t message, const can::Frame& frame) noexcept {
    Push(sent_, tick, LoggedFrame{frame, base::RealTimeNs(), tick, {}, message});
  }

  bool Incomplete() const noexcept {
    return failed_.load(std::memory_order_relaxed) || samples_.Lost() != 0 || stimuli_.Lost() != 0 ||
           received_.Lost() != 0 || sent_.Lost() != 0;
  }

  RecordingReport Finish(const std::optional<RecordingEnd>& end) noexcept;

 private:
  template <typename Ring, typename T>
  void Push(Ring& ring, std::uint64_t tick, const T& item) noexcept {
    if (options_.producers_wait) {
      ring.PushWaiting(item);
    } else {
      ring.Push(tick, item);
    }
  }

  void Run();
  /// Takes some from the rings and writes it. @return false when there was no more
  bool Round();
  bool TakeRound();
  template <typename Ring, typename Take>
  bool TakeSome(Ring& ring, RecordedStream stream, int most, const Take& take);
  void WriteRound();
  void LogUntil(std::int64_t time_ns);
  /// The gap goes to the file; once that takes no more, all losses of a stream become one gap.
  void Lose(RecordedStream stream, std::uint64_t tick, std::uint64_t lost);
  void LoseRound();
  void Fail(const std::string& problem, bool broken) noexcept;
  void WriteRest();
  void Account();

  const std::filesystem::path directory_;
  const RecorderOptions options_;
  const std::uint64_t every_ticks_;

  LossyRing<simulation::RunState, kSampleRing> samples_;
  LossyRing<FaultOrStimulus, kSampleRing> stimuli_;
  LossyRing<LoggedFrame, kFrameRing> received_;
  LossyRing<LoggedFrame, kFrameRing> sent_;
  std::atomic<std::uint64_t> newest_tick_{0};
  std::atomic<bool> failed_{false};  ///< nothing more is written but the end

  // The writer thread's; after its end, Finish()'s.
  RecordingFile file_;
  bool broken_ = false;  ///< failed, and the file takes no end either
  std::vector<simulation::RunState> round_samples_;
  std::vector<FaultOrStimulus> round_stimuli_;
  std::vector<LoggedFrame> round_received_;
  std::vector<LoggedFrame> round_sent_;
  std::vector<LoggedFrame> to_log_;  ///< in the merge window
  std::array<RecordingGap, kRecordedStreams> last_gaps_{};
  std::array<std::uint64_t, kRecordedStreams> offered_{};  ///< all that the producers gave, lost or not
  std::string problem_;
  std::optional<RecordingReport> report_;
  double cpu_s_ = 0.0;

  std::mutex mutex_;
  std::condition_variable wake_;
  bool stop_ = false;
  std::thread thread_;
};

void Recorder::Writer::Run() {
  rt::NameThread("recorder");
  PrepareThread();
  for (bool stop = false; !stop;) {
    {
      std::unique_lock lock(mutex_);
      stop = wake_.wait_for(lock, kRoundEvery, [this] { return stop_; });
    }
    while (Round()) {
    }
  }
  cpu_s_ = ThreadCpuS();
}

bool Recorder::Writer::Round() {
  bool more = false;
  try {
    more = TakeRound();
    if (!failed_) {
      const std::string lack = LackOfSpace(directory_, options_);
      if (lack.empty()) {
        WriteRound();
      } else {
        Fail(lack, false);
      }
    }
  } catch (const std::exception& error) {
    Fail(error.what(), true);
  }
  if (failed_) LoseRound();
  return more;
}

bool Recorder::Writer::TakeRound() {
  round_samples_.clear();
  round_stimuli_.clear();
  round_received_.clear();
  round_sent_.clear();
  // Samples before stimuli: those that these samples used are then among those taken after them.
  bool more = TakeSome(samples_, RecordedStream::kSamples, kSamplesPerRound,
                       [this](const simulation::RunState& sample) { round_samples_.push_back(sample); });
  constexpr int kAll = std::numeric_limits<int>::max();
  TakeSome(stimuli_, RecordedStream::kStimuli, kAll,
           [this](const FaultOrStimulus& stimulus) { round_stimuli_.push_back(stimulus); });
  more |= TakeSome(received_, RecordedStream::kReceivedFrames, kFramesPerRound,
                   [this](const LoggedFrame& frame) { round_received_.push_back(frame); });
  more |= TakeSome(sent_, RecordedStream::kSentFrames, kFramesPerRound,
                   [this](const LoggedFrame& frame) { round_sent_.push_back(frame); });
  return more;
}

template <typename Ring, typename Take>
bool Recorder::Writer::TakeSome(Ring& ring, RecordedStream stream, int most, const Take& take) {
  typename Ring::Entry entry;
  int taken = 0;
  while (taken < most && ring.TryPop(entry)) {
    ++taken;
    ++offered_[Index(stream)];
    if (entry.before.lost != 0) Lose(stream, entry.before.first_tick, entry.before.lost);
    take(entry.item);
  }
  return taken == most;
}

void Recorder::Writer::WriteRound() {
  const std::int64_t now_ns = base::MonotonicNs();
  for (const FaultOrStimulus& one : round_stimuli_)
    std::visit([&](const auto& row) { file_.Add(row, now_ns); }, one);
  for (const simulation::RunState& sample : round_samples_) file_.Add(sample, now_ns);
  for (const LoggedFrame& frame : round_sent_)
    if (frame.message != simulation::kMaxMessages)
      file_.AddPublished(frame.tick, frame.message, frame.frame, now_ns);
  to_log_.insert(to_log_.end(), round_received_.begin(), round_received_.end());
  to_log_.insert(to_log_.end(), round_sent_.begin(), round_sent_.end());
  LogUntil(base::RealTimeNs() - kMergeWindowNs);
  file_.Write(now_ns, false);
}

void Recorder::Writer::LogUntil(std::int64_t time_ns) {
  std::stable_sort(to_log_.begin(), to_log_.end(),
                   [](const LoggedFrame& a, const LoggedFrame& b) { return a.time_ns < b.time_ns; });
  auto frame = to_log_.begin();
  for (; frame != to_log_.end() && frame->time_ns <= time_ns; ++frame)
    file_.AddToLog(frame->time_ns, frame->bus, frame->frame);
  to_log_.erase(to_log_.begin(), frame);
}

void Recorder::Writer::Lose(RecordedStream stream, std::uint64_t tick, std::uint64_t lost) {
  offered_[Index(stream)] += lost;
  if (failed_) {
    RecordingGap& gap = last_gaps_[Index(stream)];
    if (gap.lost == 0) gap = {stream, tick, 0};
    gap.lost += lost;
  } else {
    file_.Add(RecordingGap{stream, tick, lost}, base::MonotonicNs());
  }
}

void Recorder::Writer::LoseRound() {
  const auto lose = [this](RecordedStream stream, std::uint64_t tick) {
    RecordingGap& gap = last_gaps_[Index(stream)];
    if (gap.lost++ == 0) gap = {stream, tick, 1};
  };
  for (const simulation::RunState& sample : round_samples_)
    lose(RecordedStream::kSamples, sample.sample.tick);
  for (const FaultOrStimulus& one : round_stimuli_)
    std::visit([&](const auto& row) { lose(RecordedStream::kStimuli, row.tick); }, one);
  for (const LoggedFrame& frame : round_received_) lose(RecordedStream::kReceivedFrames, frame.tick);
  for (const LoggedFrame& frame : round_sent_) lose(RecordedStream::kSentFrames, frame.tick);
}

void Recorder::Writer::Fail(const std::string& problem, bool broken) noexcept {
  if (!failed_) problem_ = problem;
  failed_ = true;
  broken_ = broken_ || broken;
}

void Recorder::Writer::WriteRest() {
  const std::int64_t now_ns = base::MonotonicNs();
  const auto lose_rest = [this](const auto& ring, RecordedStream stream) {
    if (const auto loss = ring.LostAtEnd(); loss.lost != 0) Lose(stream, loss.first_tick, loss.lost);
  };
  lose_rest(samples_, RecordedStream::kSamples);
  lose_rest(stimuli_, RecordedStream::kStimuli);
  lose_rest(received_, RecordedStream::kReceivedFrames);
  lose_rest(sent_, RecordedStream::kSentFrames);
  if (broken_) return;
  for (const RecordingGap& gap : last_gaps_) {
    if (gap.lost != 0) file_.Add(gap, now_ns);
  }
  LogUntil(std::numeric_limits<std::int64_t>::max());
  file_.Write(now_ns, true);
}

void Recorder::Writer::Account() {
  RecordingReport& report = *report_;
  report.samples = file_.Samples();
  report.stimuli = file_.Stimuli();
  report.frames = file_.Frames();
  report.samples_lost = offered_[Index(RecordedStream::kSamples)] - report.samples;
  report.stimuli_lost = offered_[Index(RecordedStream::kStimuli)] - report.stimuli - file_.FaultEvents();
  report.frames_lost = offered_[Index(RecordedStream::kReceivedFrames)] +
                       offered_[Index(RecordedStream::kSentFrames)] - report.frames;
  report.complete = !failed_ && report.samples_lost + report.stimuli_lost + report.frames_lost == 0;
  report.writer_cpu_s = cpu_s_;
  if (report.complete) return;
  report.problem = (failed_ ? problem_ : directory_.string() + ": the disk was too slow") +
                   base::Formatted("; lost: %llu samples, %llu influences, %llu frames",
                                   static_cast<unsigned long long>(report.samples_lost),
                                   static_cast<unsigned long long>(report.stimuli_lost),
                                   static_cast<unsigned long long>(report.frames_lost));
}

RecordingReport Recorder::Writer::Finish(const std::optional<RecordingEnd>& end) noexcept {
  if (report_) return *report_;
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
  PrepareThread();
  report_.emplace();
  try {
    WriteRest();
  } catch (const std::exception& error) {
    Fail(error.what(), true);
  }
  Account();
  if (broken_) {
    file_.Abandon();
    return *report_;
  }
  try {
    file_.Close(end, *report_);
  } catch (const std::exception& error) {
    report_->complete = false;
    if (report_->problem.empty()) report_->problem = error.what();
  }
  return *report_;
}

Recorder::Recorder(const std::filesystem::path& directory, const RecordingAttributes& attributes,
                   const signal_map::SignalMap& signal_map, const RecorderOptions& options) {
  PrepareThread();
  MakeDirectory(directory, options);
  writer_ = std::make_unique<Writer>(directory, attributes, signal_map, options);
}

Recorder::~Recorder() = default;

void Recorder::RecordTick(const simulation::RunState& run_state) noexcept {
  writer_->RecordTick(run_state);
}

void Recorder::RecordStimulus(const Stimulus& stimulus) noexcept {
  writer_->RecordStimulus(stimulus);
}

void Recorder::RecordFaultEvent(const fault::Event& event) noexcept {
  writer_->RecordFaultEvent(event);
}

void Recorder::RecordReceived(const can::Frame& frame, std::size_t bus) noexcept {
  writer_->RecordReceived(frame, bus);
}

void Recorder::RecordSent(std::uint64_t tick, std::size_t message, const can::Frame& frame) noexcept {
  writer_->RecordSent(tick, message, frame);
}

bool Recorder::Incomplete() const noexcept {
  return writer_->Incomplete();
}

RecordingReport Recorder::Finish(const RecordingEnd& end) noexcept {
  return writer_->Finish(end);
}

}  // namespace servohil::recording
