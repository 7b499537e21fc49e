#include "emulator/sender_schedule.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

namespace servohil::emulator {
namespace {

std::array<std::uint64_t, simulation::kMaxMessages> Cycles(std::initializer_list<std::uint64_t> ticks) {
  std::array<std::uint64_t, simulation::kMaxMessages> cycles{};
  std::copy(ticks.begin(), ticks.end(), cycles.begin());
  return cycles;
}

/// Whatever cycles, wake period and first tick: the sender looks after each wake-up in which something became
/// due, and at no others but those that `most_wakes` asks for.
TEST(SenderSchedule, VisitsExactlyTheWakeUpsAfterWhichSomethingIsDue) {
  constexpr std::uint64_t kNeverIdle = 1'000'000;
  for (const std::uint64_t wake_ticks : std::vector<std::uint64_t>{1, 7, 10, 100}) {
    for (const std::uint64_t first : std::vector<std::uint64_t>{0, 1, 12345}) {
      const std::vector<std::uint64_t> cycles = {100, 130, 1000};
      const SenderSchedule schedule(Cycles({100, 130, 1000}), wake_ticks, first, kNeverIdle);
      std::set<std::uint64_t> expected;
      for (std::uint64_t tick = first + 1; tick <= first + 5'000; ++tick) {
        for (const std::uint64_t cycle : cycles) {
          if (tick % cycle == 0) expected.insert((tick - first + wake_ticks - 1) / wake_ticks);
        }
      }
      std::set<std::uint64_t> visited;
      const std::uint64_t last = *expected.rbegin();
      for (std::uint64_t wake = schedule.Next(0); wake <= last; wake = schedule.Next(wake))
        visited.insert(wake);
      EXPECT_EQ(visited, expected) << wake_ticks << " ticks a wake, after " << first;
    }
  }
}

TEST(SenderSchedule, LooksNowAndThenWhereNothingIsDueByCycle) {
  const SenderSchedule schedule(Cycles({}), 10, 0, 20);
  EXPECT_EQ(schedule.Next(1), 21U);
  EXPECT_EQ(schedule.NewestDue(21), 0U);
}

TEST(SenderSchedule, KnowsTheNewestTickThatIsDue) {
  const SenderSchedule schedule(Cycles({100, 30}), 10, 0, 20);
  EXPECT_EQ(schedule.NewestDue(2), 0U);
  EXPECT_EQ(schedule.NewestDue(3), 30U);
  EXPECT_EQ(schedule.NewestDue(10), 100U);
  EXPECT_EQ(schedule.NewestDue(11), 100U);
}

}  // namespace
}  // namespace servohil::emulator
