// Linear theory as an oracle: where oscillation starts and stops in simulation is where the eigenvalues of
// the linearised model cross the imaginary axis; with dry friction, where its describing function says so.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <limits>
#include <numbers>

#include "bench.hpp"
#include "linear/linearization.hpp"

namespace servohil::fault {
namespace {

using model::Parameters;
using testing::Bench;
using testing::Full;

using Variant = std::function<Parameters(double)>;

/// MIL-H-5606 without air: its modulus.
Parameters CleanOil() {
  Parameters p = testing::Full();
  p.servo.bulk_modulus_psi = 230'000.0;
  return p;
}

double Growth(const Parameters& p) {
  const model::Derived d(p);
  return linear::Poles(linear::Linearize(d, model::SteadyStateAt(d, 4.0)).system).LargestRealPart();
}

/// Peak to peak of the velocity during `ticks`.
double Swing(Bench& bench, int ticks) {
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (int i = 0; i < ticks; ++i) {
    const double v3_in_s = bench.Run(1).state.v3_in_s;
    least = std::min(least, v3_in_s);
    most = std::max(most, v3_in_s);
  }
  return most - least;
}

/// Where `oscillates` changes between two values, of which `calm` is one where it does not.
double LimitOf(const std::function<bool(double)>& oscillates, double calm, double oscillating) {
  EXPECT_FALSE(oscillates(calm));
  EXPECT_TRUE(oscillates(oscillating));
  while (std::fabs(oscillating - calm) > 1e-3 * std::max(std::fabs(calm), std::fabs(oscillating)))
    (oscillates(0.5 * (calm + oscillating)) ? oscillating : calm) = 0.5 * (calm + oscillating);
  return 0.5 * (calm + oscillating);
}

/// A push of 1e-4 in/s at rest: does its swing grow? After 0.2 s all other modes, the slowest of which takes
/// 25 ms, have left less than 1e-3 of it.
bool GrowsFromRest(const Parameters& p) {
  constexpr int kWindowTicks = 300;  // 30 ms: three periods of 103 Hz or more
  Bench bench(p);
  simulation::Sample pushed = bench.simulation.Now();
  pushed.state.v3_in_s = 1e-4;
  bench.simulation.Restore(pushed, {});
  bench.Run(2'000);
  const double early = Swing(bench, kWindowTicks);
  bench.Run(2'000);
  return Swing(bench, kWindowTicks) > early;
}

constexpr int kPeriodTicks = 100;  ///< a little more than one period of 103 Hz or more

/// The limit in simulation is within 3 % of that of the state matrix.
void ExpectSameLimit(const Variant& with, double calm, double oscillating) {
  const double simulated = LimitOf([&](double x) { return GrowsFromRest(with(x)); }, calm, oscillating);
  const double linear = LimitOf([&](double x) { return Growth(with(x)) > 0.0; }, calm, oscillating);
  std::cout << "oscillation from " << simulated << " on in simulation, " << linear
            << " by the state matrix\n";
  EXPECT_NEAR(simulated, linear, 0.03 * std::fabs(linear));
}

TEST(StabilityLimit, OfAirIsThatOfTheStateMatrix) {
  ExpectSameLimit([](double fraction) { return testing::Under(CleanOil(), "air_entrainment", {fraction}); },
                  0.0, 0.02);
}

TEST(StabilityLimit, OfUnderlapIsThatOfTheStateMatrix) {
  ExpectSameLimit(
      [](double underlap_in) {
        Parameters p = CleanOil();
        p.servo.relay_plunger_clearance_in = 0.0;  // Table IV, rows 1 and 2
        p.servo.relay_piston_clearance_in = 0.0;
        p.servo.underlap_in = underlap_in;
        return p;
      },
      0.002, 0.001);
}

TEST(StabilityLimit, OfViscousFrictionIsThatOfTheStateMatrix) {
  ExpectSameLimit(
      [](double viscous_psi_s_in) {
        Parameters p = testing::Under(CleanOil(), "air_entrainment", {0.01});
        p.friction.viscous_psi_s_in = viscous_psi_s_in;
        return p;
      },
      1.0, 0.0);
}

/// An unstable servomotor whose oscillation has grown to a velocity amplitude of `amplitude_in_s`.
Bench Oscillating(const Parameters& p, double amplitude_in_s) {
  Bench bench(p);
  simulation::Sample pushed = bench.simulation.Now();
  pushed.state.v3_in_s = 0.5 * amplitude_in_s;
  bench.simulation.Restore(pushed, {});
  bench.Run(2'000);
  while (Swing(bench, kPeriodTicks) < 2.0 * amplitude_in_s) {
  }
  return bench;
}

/// Dry friction B [psi] takes the power of a viscous friction 4 B/(π V) from a sine of velocity amplitude V:
/// its describing function (Gelb and Vander Velde, Multiple-Input Describing Functions and Nonlinear System
/// Design, 1968, section 2.3). An oscillation of amplitude V dies if that is more than the viscous friction
/// B_v at which the eigenvalues cross the axis, else it grows: B = π/4 V B_v. The third harmonic of the
/// friction, a third of the first, moves the piston by less than 1/27 of that part of its swing which
/// friction moves at all.
TEST(StabilityLimit, OfDryFrictionIsThatOfItsDescribingFunction) {
  const Parameters unstable = testing::Under(CleanOil(), "air_entrainment", {0.009});
  const double viscous_psi_s_in = LimitOf(
      [&](double x) {
        Parameters p = unstable;
        p.friction.viscous_psi_s_in = x;
        return Growth(p) > 0.0;
      },
      5.0, 0.0);
  const Bench start = Oscillating(unstable, 0.05);  // small: all but friction is linear
  Bench undisturbed = start;
  const double amplitude_in_s = 0.5 * Swing(undisturbed, kPeriodTicks);  // grows by 0.5 % in a period
  const double expected_psi = 0.25 * std::numbers::pi * amplitude_in_s * viscous_psi_s_in;
  const auto grows = [&](double psi) {
    Bench bench = start;
    bench.Inject("coulomb_friction", {psi});
    bench.Run(1'000);
    const double early = Swing(bench, kPeriodTicks);
    bench.Run(2'000);
    return Swing(bench, kPeriodTicks) > early;
  };
  const double simulated_psi = LimitOf(grows, 3.0 * expected_psi, 0.0);
  std::cout << "an oscillation of " << amplitude_in_s << " in/s dies from " << simulated_psi
            << " psi on in simulation, " << expected_psi << " psi by its describing function\n";
  EXPECT_NEAR(simulated_psi, expected_psi, 0.03 * expected_psi);
}

}  // namespace
}  // namespace servohil::fault
