#include "simulation/simulation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/default_setup.hpp"

namespace servohil::simulation {
namespace {

TEST(Simulation, RestsUntilItIsTicked) {
  const testing::DefaultSetup setup;
  Simulation simulation(setup.configuration.model, setup.start);
  for (int i = 0; i < 100; ++i) simulation.Rest();
  EXPECT_EQ(simulation.Now().tick, 100U);
  EXPECT_EQ(simulation.Now().state.Vector(), setup.start.state.Vector());
  EXPECT_EQ(simulation.Now().p1_psi, setup.start.p1_psi);
}

TEST(Simulation, AStateOutsideTheModelIsNeverShown) {
  const testing::DefaultSetup setup({"model.physics=thesis"});
  model::SteadyState start = setup.start;
  start.state.x3_in = -0.37;  // V3 = 30 + 78.4 x3 = 1 in³, and at 500 in/s less than nothing within the tick
  start.state.v3_in_s = -500.0;
  Simulation simulation(setup.configuration.model, start);
  simulation.Tick(start.p1_psi);
  const Sample& now = simulation.Now();
  ASSERT_TRUE(now.model_fault);
  EXPECT_EQ(now.state.Vector(), start.state.Vector()) << "the last good state";
  EXPECT_TRUE(model::IsInDomain(setup.derived, now.state));
  simulation.Tick(start.p1_psi);
  EXPECT_TRUE(simulation.Now().model_fault) << "latched";
  EXPECT_EQ(simulation.Now().tick, 2U) << "time goes on";
}

TEST(Simulation, ANonFiniteCommandIsAFaultNotAState) {
  const testing::DefaultSetup setup;
  Simulation simulation(setup.configuration.model, setup.start);
  simulation.Tick(std::nan(""));
  EXPECT_TRUE(simulation.Now().model_fault);
  EXPECT_TRUE(simulation.Now().state.Vector().allFinite());
  EXPECT_EQ(simulation.Now().p1_psi, setup.start.p1_psi);
}

}  // namespace
}  // namespace servohil::simulation
