#pragma once
/// The main thread while the emulator runs: signals, status line, statistics, snapshots, service manager, and
/// what must be told at once.

#include <filesystem>

#include "can/network.hpp"
#include "control/server.hpp"
#include "emulator/emulator.hpp"
#include "run/bus_watch.hpp"
#include "run/frame_log.hpp"
#include "run/reload.hpp"
#include "run/service_manager.hpp"
#include "run/snapshot_writer.hpp"
#include "run/stop_signals.hpp"

namespace servohil::run {

class Watch {
 public:
  /// Before the emulator starts. @param statistics  file to write each second; empty: none
  /// @param control  null: none
  /// @param reloader  called at SIGHUP. All must outlive it.
  Watch(emulator::Emulator& emulator, const can::Network& network, const emulator::EmulatorOptions& options,
        std::filesystem::path statistics, const SnapshotWriter& snapshots, control::Server* control,
        Reloader& reloader, BusWatch& buses);

  /// Until a stop signal or the end of the run.
  void Run(const StopSignals& signals);

 private:
  /// Until something comes or it is time to look around. @return whether the run has ended
  bool Wait(const StopSignals& signals);
  /// @return whether one asked for the end
  bool TakeSignals(const StopSignals& signals);
  void Reload();
  void NotifyWatchdog();
  void LogWhatWentWrong();
  void LogSafetyChanges();
  void LogFrames();
  void LogSilentGovernor();
  std::string OnLossText(simulation::SafetyCause cause) const;
  std::string TimeOutText() const;
  void LogSaturation();
  void LogFaults();
  void WriteStatisticsSoFar();
  void TellEachSecond();

  emulator::Emulator& emulator_;
  const can::Network& network_;
  const emulator::EmulatorOptions& options_;
  std::filesystem::path statistics_;
  const SnapshotWriter& snapshots_;
  control::Server* control_;
  Reloader& reloader_;
  ServiceManager manager_;
  BusWatch& buses_;
  FrameLog frames_;
  bool told_silence_ = false;
  simulation::RunState now_;
  std::uint64_t overruns_ = 0;
  bool timing_valid_ = true;
  std::array<signal_map::FieldSet, simulation::kMaxMessages>
      told_saturated_{};  ///< signals that have been named in the log
  std::uint64_t snapshots_refused_ = 0;
  bool terminal_;
  std::int64_t last_ns_;
  std::uint64_t last_tick_ = 0;
  std::uint64_t loop_iterations_ = 0;
};

}  // namespace servohil::run
