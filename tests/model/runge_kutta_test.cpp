#include "model/runge_kutta.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "model/servomotor.hpp"
#include "model/steady_state.hpp"
#include "model/step.hpp"
#include "nominal.hpp"

namespace servohil::model {
namespace {

using Vector2 = Eigen::Vector2d;

/// Error at t = 1 for y' = (y2, -y1) + known solution (sin, cos).
double OscillatorError(int steps) {
  Vector2 y(0.0, 1.0);
  for (int i = 0; i < steps; ++i) {
    y = RungeKutta4([](const Vector2& v) { return Vector2(v[1], -v[0]); }, y, 1.0 / steps);
  }
  return (y - Vector2(std::sin(1.0), std::cos(1.0))).norm();
}

TEST(RungeKutta4, HalvingTheStepDividesTheErrorBySixteen) {
  const double order = std::log2(OscillatorError(20) / OscillatorError(40));
  EXPECT_NEAR(order, 4.0, 0.1);
}

TEST(RungeKutta4, AQuarticInTimeIsExact) {
  // y' = 4 t³ (time as second component): Simpson's rule, exact to degree 3 in the slope.
  Vector2 y(0.0, 0.0);
  for (int i = 0; i < 10; ++i) {
    y = RungeKutta4([](const Vector2& v) { return Vector2(4.0 * v[1] * v[1] * v[1], 1.0); }, y, 0.1);
  }
  EXPECT_NEAR(y[0], 1.0, 1e-15);
}

/// P3, the fastest variable, 30 ms after a P1 step, integrated in `parts` steps a tick.
double ServoPressure(int parts) {
  const Derived d(testing::Nominal());
  const SteadyState start = SteadyStateAt(d, 4.0);
  State state = start.state;
  for (int i = 0; i < 300 * parts; ++i) state = Step(d, state, start.p1_psi + 0.02, kTickS / parts).state;
  return state.p3_psi;
}

TEST(Step, IsOfFourthOrderWhereNoKinkIsCrossed) {
  // 0.02 psi: relay port and metering ports stay open and no row of the load table is crossed, so all is
  // smooth.
  const double exact = ServoPressure(64);
  const double e1 = ServoPressure(1) - exact;
  const double e2 = ServoPressure(2) - exact;
  EXPECT_NEAR(std::log2(e1 / e2), 4.0, 0.1);
}

}  // namespace
}  // namespace servohil::model
