/// Nothing is allocated and no page faults in the loop after its start. malloc and its kin are replaced by
/// ones that count, per thread, and pass on to glibc's.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <thread>

#include "recording/recorder.hpp"
#include "rt/periodic_loop.hpp"
#include "rt/process.hpp"
#include "support/default_setup.hpp"
#include "support/scratch.hpp"

namespace {
thread_local long allocations_of_this_thread =
    0;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
}

extern "C" {
void* __libc_malloc(std::size_t size);                     // NOLINT: glibc's names
void* __libc_calloc(std::size_t count, std::size_t size);  // NOLINT
void* __libc_realloc(void* old, std::size_t size);         // NOLINT

void* malloc(std::size_t size) {
  ++allocations_of_this_thread;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations_of_this_thread;
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  ++allocations_of_this_thread;
  return __libc_realloc(old, size);
}
}

namespace servohil::emulator {
namespace {

recording::RecordingAttributes AttributesOf(const testing::DefaultSetup& setup) {
  recording::RecordingAttributes attributes;
  static_cast<configuration::RunTexts&>(attributes) =
      configuration::DescribeConfiguration(setup.configuration);
  return attributes;
}

TEST(Allocations, AreSeenByThisTest) {
  const long before = allocations_of_this_thread;
  const auto something = std::make_unique<double>(1.0);
  EXPECT_GT(allocations_of_this_thread, before) << "else the tests below could not fail";
}

TEST(Allocations, AndPageFaultsAreNoneInTenThousandTicksAfterTheStart) {
  // Friction, stabilizer, commands, publishing: everything the loop can do.
  const testing::DefaultSetup setup(
      {"friction.coulomb_psi=5", "stabilizer.enabled=true", "loop.wake_ticks=1"});
  TaskOptions options = setup.Options();
  options.duration_ticks = 10'000;
  const auto task = std::make_unique<SimulationTask>(setup.configuration.model, setup.start, options);
  long allocations = -1;
  long page_faults = -1;
  std::uint64_t wakes = 0;
  rt::LockMemory();  // as the emulator does: code that only a late wake-up runs is there, too
  std::thread simulator([&] {
    rt::PrefaultStack();
    rt::PeriodicLoop loop(100'000);
    const std::atomic<bool> stop{false};
    testing::Governor governor(*task);
    simulation::Publication drained;
    const long faults_before = rt::ThreadPageFaults();
    const long allocations_before = allocations_of_this_thread;
    loop.Run(stop, [&](const rt::LoopTiming& timing) noexcept {
      if (timing.wakes % 100 == 0)
        governor.Send(setup.start.p1_psi + static_cast<double>(timing.wakes) * 1e-4);
      while (task->TryPopPublication(drained)) {
      }
      return task->Wake(timing);
    });
    allocations = allocations_of_this_thread - allocations_before;
    page_faults = rt::ThreadPageFaults() - faults_before;
    wakes = loop.Timing().wakes;
  });
  simulator.join();
  EXPECT_EQ(wakes, 10'000U);
  EXPECT_EQ(allocations, 0);
  EXPECT_EQ(page_faults, 0);
}

/// Every fault there is comes, ramps, acts and goes. @return most that acted at once
std::uint64_t RunAllFaults(SimulationTask& task) {
  std::uint64_t most_active = 0;
  for (const fault::Spec& spec : fault::Catalogue()) {
    simulation::Request request;
    request.injection.id = spec.id;
    for (std::size_t i = 0; i < fault::kMaxParameters; ++i)
      request.injection.values[i] = spec.parameters[i].preset;
    if (spec.HasSignal()) request.injection.target = 0;
    request.injection.ramp_ticks = 20;
    request.injection.for_ticks = 100;
    task.PutRequest(request);
    task.Run(40);
    most_active = std::max(most_active, task.Now().status.active_faults);
  }
  return most_active;
}

TEST(Allocations, AndPageFaultsAreNoneWhereFaultsAct) {
  const testing::DefaultSetup setup({"stabilizer.enabled=true", "load.beyond=\"hold\""});
  const auto make = [&] {
    auto task = std::make_unique<SimulationTask>(setup.configuration.model, setup.start, setup.Options());
    testing::Governor(*task).Send(setup.start.p1_psi);
    return task;
  };
  EXPECT_GE(RunAllFaults(*make()), 2U) << "and the program's own pages are there";
  const auto task = make();
  long allocations = -1;
  long page_faults = -1;
  std::thread simulator([&] {
    rt::PrefaultStack();
    const long faults_before = rt::ThreadPageFaults();
    const long allocations_before = allocations_of_this_thread;
    RunAllFaults(*task);
    allocations = allocations_of_this_thread - allocations_before;
    page_faults = rt::ThreadPageFaults() - faults_before;
  });
  simulator.join();
  EXPECT_EQ(allocations, 0);
  EXPECT_EQ(page_faults, 0);
}

/// A tick is recorded without allocating, whatever becomes of the ring.
TEST(Allocations, AreNoneWhereATickIsRecorded) {
  const testing::Scratch scratch;
  const testing::DefaultSetup setup;
  recording::Recorder recorder(scratch / "run", AttributesOf(setup), setup.signal_map);
  const can::Frame frame = setup.signal_map.Encode(testing::kPosition, {});
  simulation::RunState run_state;
  const long before = allocations_of_this_thread;
  while (!recorder.Incomplete()) {  // more than the ring holds
    ++run_state.sample.tick;
    recorder.RecordStimulus({run_state.sample.tick, {}});
    recorder.RecordTick(run_state);
    recorder.RecordReceived(frame, 0);
    recorder.RecordSent(run_state.sample.tick, testing::kPosition, frame);
  }
  EXPECT_EQ(allocations_of_this_thread, before);
}

}  // namespace
}  // namespace servohil::emulator
