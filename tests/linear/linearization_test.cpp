#include "linear/linearization.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <vector>

#include "model/nominal.hpp"

namespace servohil::linear {
namespace {

using Wide = long double;
using WideState = std::array<Wide, 5>;

/// The equations of chapters II and V once more, in 64-bit mantissas, written from the thesis and valid
/// inside one segment of the load table (slope and value of p_L at the point).
struct Equations {
  const model::Derived& d;
  double x3_in;
  double p1_psi;

  WideState operator()(const WideState& y) const {
    const auto [x3, v3, P3, P4, P8] = y;
    const auto port = [](Wide k, Wide x, Wide c, Wide dP) {
      return k * std::sqrt(((x > 0 ? x * x : 0) + c * c) * dP);
    };
    const Wide load = d.load_up.PressureAt(x3_in) + d.load_up.SlopeAt(x3_in) * (x3 - x3_in);
    const Wide alpha = d.cam.SlopeAt(x3_in);
    const Wide x4 = d.cam.At(x3_in) + alpha * (x3 - x3_in);
    const Wide x = (P4 * d.A2 - d.Fs) / d.k2;
    const Wide x1 = static_cast<Wide>(p1_psi) * d.A1 / d.k1;
    const Wide Q3 = port(d.k_metering, d.U + x, d.cr2, d.P2 - P3);
    const Wide Q6 = port(d.k_metering, d.U - x, d.cr2, P3);
    const Wide Q5 = port(d.k_relay, x + x4 - x1, d.cr1, P4);
    const Wide Q4 = (-1 + std::sqrt(1 + 4 * static_cast<Wide>(d.capillary_b) * (d.P2 - P4) / d.capillary_a)) /
                    (2 * static_cast<Wide>(d.capillary_b));
    const Wide Q8 = d.stabilizer ? (P3 - P8) / d.R7 : Wide{0};
    return {v3, (d.A3 * (P3 - load) - d.C * v3) / d.M,
            d.beta * (Q3 - Q6 - Q8 - d.A3 * v3 - d.c3 * P3) / (d.V3_at_zero + d.A3 * x3),
            (Q4 - Q5 - d.A2 * alpha * v3) / (d.V4 / d.beta + d.spring_compliance),
            Q8 / (d.V8 / d.beta + d.Va / d.k_gas / P8)};
  }
};

/// dF_i/dy_j: differences of fourth order, h = 1e-4 of the scale on which the laws bend: error 1e-14 by the
/// step, 1e-14 by rounding.
Wide Slope(const Equations& f, WideState y, std::size_t i, std::size_t j) {
  constexpr std::array<Wide, 5> kWidth = {1e-5L, 1e-3L, 1e-3L, 1e-5L, 1e-3L};
  const Wide h = kWidth[j];
  const auto at = [&](int steps) {
    WideState moved = y;
    moved[j] += steps * h;
    return f(moved)[i];
  };
  return (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * h);
}

/// Nominal, small underlap without clearance, two-slope cam, recommended and stiffest stabilizer.
std::vector<model::Parameters> ParameterSets() {
  std::vector<model::Parameters> sets(5, model::testing::Nominal());
  sets[1].servo.underlap_in = 0.001;
  sets[1].servo.relay_piston_clearance_in = sets[1].servo.relay_plunger_clearance_in = 0.0;
  sets[1].servo.bulk_modulus_psi = 230e3;
  sets[2].cam.shape = model::CamShape::kTwoSlope;
  sets[3].stabilizer.enabled = true;
  sets[4].stabilizer = {true, 0.10, 8.2, 98.0, 98.0, 1.4};
  return sets;
}

TEST(Linearize, IsTheDerivativeInHigherPrecision) {
  for (const model::Parameters& p : ParameterSets()) {
    const model::Derived d(p);
    for (const double x3 : {0.6, 1.9, 3.1, 3.37, 4.0, 5.6, 6.9}) {
      const model::SteadyState rest = model::SteadyStateAt(d, x3);
      ASSERT_TRUE(rest);
      const Linearization linear = Linearize(d, rest);
      ASSERT_EQ(linear.system.A.rows(), p.stabilizer.enabled ? 5 : 4);
      const Equations f{d, x3, rest.p1_psi};
      const model::StateVector y = rest.state.Vector();
      const WideState wide = {y[0], y[1], y[2], y[3], y[4]};
      const LinearVector factor = BalanceFactors(linear.system.A);
      const double scale = (factor.cwiseInverse().asDiagonal() * linear.system.A * factor.asDiagonal())
                               .eval()
                               .cwiseAbs()
                               .maxCoeff();
      for (Eigen::Index i = 0; i < linear.system.A.rows(); ++i) {
        for (Eigen::Index j = 0; j < linear.system.A.cols(); ++j) {
          const auto exact =
              static_cast<double>(Slope(f, wide, static_cast<std::size_t>(i), static_cast<std::size_t>(j)));
          const double error = std::fabs(linear.system.A(i, j) - exact) * factor[j] / factor[i];
          // Extrapolated differences in double: 1e-16 of flows of 50 in³/s over widths of 1e-3 and more.
          EXPECT_LE(error, 1e-10 * scale) << "x3 " << x3 << ", entry " << i << ", " << j;
        }
      }
      // The bound that is stated with it holds, but for the rounding of the reference itself.
      EXPECT_LT(linear.relative_error, 1e-8) << "x3 " << x3;
    }
  }
}

TEST(Linearize, StatesABoundThatHolds) {
  for (const model::Parameters& p : ParameterSets()) {
    const model::Derived d(p);
    for (int k = 0; k < 25; ++k) {
      const double x3 = 0.31 + 0.31 * k;  // no row of the load table
      const model::SteadyState rest = model::SteadyStateAt(d, x3);
      const Linearization linear = Linearize(d, rest);
      const Equations f{d, x3, rest.p1_psi};
      const model::StateVector y = rest.state.Vector();
      const WideState wide = {y[0], y[1], y[2], y[3], y[4]};
      for (Eigen::Index i = 0; i < linear.system.A.rows(); ++i) {
        for (Eigen::Index j = 0; j < linear.system.A.cols(); ++j) {
          const auto exact =
              static_cast<double>(Slope(f, wide, static_cast<std::size_t>(i), static_cast<std::size_t>(j)));
          const double error = std::fabs(linear.system.A(i, j) - exact);
          EXPECT_LE(error, linear.A_error(i, j) + 1e-11 * std::fabs(exact))
              << "x3 " << x3 << ", entry " << i << ", " << j;
        }
      }
    }
  }
}

TEST(Linearize, TheInputMovesTheRelayOnly) {
  // dP4/dt = -dQ5/dx1 A1/k1 / compliance; at the nominal point 6834.2 psi/s per psi.
  const model::Derived d(model::testing::Nominal());
  const model::SteadyState rest = model::SteadyStateAt(d, 4.0);
  const LinearVector b = Linearize(d, rest).system.B;
  const double opening = rest.outputs.x2_in - rest.outputs.x1_in;
  const double dQ5 = d.k_relay * std::sqrt(rest.state.p4_psi) * opening / std::hypot(opening, d.cr1);
  EXPECT_EQ(b[model::kX3], 0.0);
  EXPECT_EQ(b[model::kV3], 0.0);
  EXPECT_EQ(b[model::kP3], 0.0);
  EXPECT_NEAR(b[model::kP4] / (dQ5 * d.A1 / d.k1 / (d.V4 / d.beta + d.spring_compliance)), 1.0, 1e-10);
}

TEST(Linearize, TakesTheRightSideOfAKink) {
  const model::Derived d(model::testing::Nominal());
  const double k3_over_M =
      d.A3 * 10.0 / d.M;  // right of 2.0 in the load falls by 10 psi/in, left of it by 12
  const Linearization linear = Linearize(d, model::SteadyStateAt(d, 2.0));
  EXPECT_TRUE(linear.kinked[model::kX3]);
  EXPECT_FALSE(linear.kinked[model::kP3]);
  EXPECT_NEAR(linear.system.A(model::kV3, model::kX3) / k3_over_M, 1.0, 1e-9);
  EXPECT_FALSE(Linearize(d, model::SteadyStateAt(d, 4.0)).kinked[model::kX3])
      << "a row of the table, but no change of slope";

  model::Parameters p = model::testing::Nominal();
  p.cam.shape = model::CamShape::kTwoSlope;
  const model::Derived two(p);
  EXPECT_TRUE(Linearize(two, model::SteadyStateAt(two, two.cam.knee_x3_in())).kinked[model::kX3]);
}

TEST(Linearize, IsExactWhereALawIsSmoothOnlyOnce) {
  // At rest nothing flows into the stabilizer; its full law is dP = R7 Q + (end losses) Q |Q|: slope 1/R7.
  model::Parameters p = model::testing::Nominal();
  p.physics = model::Physics::kFull;
  p.stabilizer.enabled = true;
  const model::Derived d(p);
  const model::SteadyState rest = model::SteadyStateAt(d, 4.0);
  const Linearization linear = Linearize(d, rest);
  EXPECT_LT(linear.relative_error, 1e-6);
  const double per_flow =
      -linear.system.A(model::kP3, model::kV3) / d.A3;  // psi/s of P3 per in³/s out of its chamber
  EXPECT_NEAR(linear.system.A(model::kP3, model::kP8) / per_flow * d.R7, 1.0, 1e-6);
}

TEST(Linearize, FrictionIsLeftOut) {
  const model::Derived free(model::testing::Nominal());
  const model::Derived stuck(model::testing::WithFriction(5.0));
  EXPECT_EQ(Linearize(free, model::SteadyStateAt(free, 4.0)).system.A,
            Linearize(stuck, model::SteadyStateAt(stuck, 4.0)).system.A);
}

TEST(Linearize, PredictsASmallStepOfTheNonlinearModel) {
  // 1e-5 psi: quadratic terms are 1e-5 / 0.3 psi (what closes the relay port) of the response.
  const model::Derived d(model::testing::Nominal());
  const model::SteadyState rest = model::SteadyStateAt(d, 4.0);
  const LinearSystem system = Linearize(d, rest).system;
  const double final_in = -system.A.partialPivLu().solve(system.B)[0];
  const model::SteadyState moved = model::SteadyStateForP1(d, rest.p1_psi + 1e-5);
  EXPECT_NEAR((moved.state.x3_in - 4.0) / 1e-5 / final_in, 1.0, 1e-4);
}

TEST(WithBushingHeld, KeepsTheOperatingPointAndDropsTheFeedback) {
  const model::Parameters p = model::testing::Nominal();
  const model::SteadyState rest = model::SteadyStateAt(model::Derived(p), 4.0);
  const model::Derived held(WithBushingHeld(p, 4.0));
  EXPECT_LT(model::Rates(held, rest.state.Vector(), model::Motion::kFree, rest.p1_psi).cwiseAbs().maxCoeff(),
            1e-6);
  const Linearization linear = Linearize(held, rest);
  EXPECT_EQ(linear.system.A(model::kP4, model::kX3), 0.0);
  EXPECT_EQ(linear.system.A(model::kP4, model::kV3), 0.0);
}

}  // namespace
}  // namespace servohil::linear
