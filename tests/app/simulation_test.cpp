#include "servohil/app/simulation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "default_setup.hpp"

namespace servohil::app {
namespace {

TEST(Simulation, RestsUntilItIsTicked) {
  const testing::DefaultSetup setup;
  Simulation simulation(setup.derived, setup.start);
  for (int i = 0; i < 100; ++i) simulation.Rest();
  EXPECT_EQ(simulation.Now().tick, 100U);
  EXPECT_EQ(simulation.Now().state.Vector(), setup.start.state.Vector());
  EXPECT_EQ(simulation.Now().p1_psi, setup.start.p1_psi);
}

TEST(Simulation, AStateOutsideTheModelIsNeverShown) {
  const testing::DefaultSetup setup({"model.physics=thesis", "stabilizer.enabled=true"});
  Simulation simulation(setup.derived, setup.start);
  int ticks = 0;
  Sample last = simulation.Now();
  // P1 = 300 psi drives the piston far beyond the load table, which pulls it up there: P3 and P8 fall below
  // 0.
  for (; ticks < 100'000 && !simulation.Now().model_fault; ++ticks) {
    last = simulation.Now();
    simulation.Tick(300.0);
  }
  const Sample& now = simulation.Now();
  ASSERT_TRUE(now.model_fault);
  EXPECT_EQ(now.state.Vector(), last.state.Vector()) << "the last good state";
  EXPECT_TRUE(model::IsInDomain(setup.derived, now.state));
  const std::uint64_t tick = now.tick;
  simulation.Tick(setup.start.p1_psi);
  EXPECT_TRUE(simulation.Now().model_fault) << "latched";
  EXPECT_EQ(simulation.Now().tick, tick + 1) << "time goes on";
}

TEST(Simulation, ANonFiniteCommandIsAFaultNotAState) {
  const testing::DefaultSetup setup;
  Simulation simulation(setup.derived, setup.start);
  simulation.Tick(std::nan(""));
  EXPECT_TRUE(simulation.Now().model_fault);
  EXPECT_TRUE(simulation.Now().state.Vector().allFinite());
  EXPECT_EQ(simulation.Now().p1_psi, setup.start.p1_psi);
}

}  // namespace
}  // namespace servohil::app
