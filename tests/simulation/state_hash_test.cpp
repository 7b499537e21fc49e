#include "simulation/state_hash.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <set>

#include "support/default_setup.hpp"

namespace servohil::simulation {
namespace {

std::uint64_t HashOf(Sample sample) {
  ExtendStateHash(sample);
  return sample.state_hash;
}

TEST(StateHash, AnyFlippedBitChangesIt) {
  Sample sample{.tick = 1234, .p1_psi = 30.263, .state = {4.0, -0.125, 103.3, 96.5, 103.3, 300.0, {}}};
  double Sample::*const p1 = &Sample::p1_psi;
  std::set<std::uint64_t> seen = {HashOf(sample)};
  const auto flip_each_bit = [&](double& value) {
    for (unsigned bit = 0; bit < 64; ++bit) {
      const double before = value;
      std::uint64_t bits = 0;
      std::memcpy(&bits, &value, sizeof bits);
      bits ^= std::uint64_t{1} << bit;
      std::memcpy(&value, &bits, sizeof bits);
      EXPECT_TRUE(seen.insert(HashOf(sample)).second) << "bit " << bit;
      value = before;
    }
  };
  model::State& s = sample.state;
  for (double* value : {&(sample.*p1), &s.x3_in, &s.v3_in_s, &s.p3_psi, &s.p4_psi, &s.p8_psi, &s.p2_psi})
    flip_each_bit(*value);
  s.mode.motion = model::Motion::kStuck;
  EXPECT_TRUE(seen.insert(HashOf(sample)).second);
  s.mode.plunger = model::Plunger::kAtUpperStop;
  EXPECT_TRUE(seen.insert(HashOf(sample)).second);
  s.mode.diaphragm_seated = true;
  EXPECT_TRUE(seen.insert(HashOf(sample)).second);
  s.mode.relay_port_full = true;
  EXPECT_TRUE(seen.insert(HashOf(sample)).second);
  sample.model_fault = true;
  EXPECT_TRUE(seen.insert(HashOf(sample)).second);
  sample.unresolved_ticks = 1;
  EXPECT_TRUE(seen.insert(HashOf(sample)).second);
}

TEST(StateHash, RemembersThePast) {
  const testing::DefaultSetup setup;
  Simulation one(setup.configuration.model, setup.start);
  Simulation other(setup.configuration.model, setup.start);
  one.Tick(setup.start.p1_psi);
  other.Tick(setup.start.p1_psi + 1e-9);
  Sample sample = other.Now();
  sample.state = one.Now().state;
  sample.p1_psi = one.Now().p1_psi;
  other.Restore(sample, {});  // the same state by another way
  EXPECT_NE(one.Rest().state_hash, other.Rest().state_hash);
}

}  // namespace
}  // namespace servohil::simulation
