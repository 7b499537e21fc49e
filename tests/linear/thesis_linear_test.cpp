#include "linear/thesis_linear.hpp"

#include <gtest/gtest.h>

#include <array>

#include "model/nominal.hpp"

namespace servohil::linear {
namespace {

ThesisCoefficients At(const model::Parameters& p, const ThesisLinearOptions& options = {}) {
  const model::Derived d(p);
  return ThesisCoefficientsAt(p, d, model::SteadyStateAt(d, 4.0), options);
}

model::Parameters With(double bulk_modulus_psi) {
  model::Parameters p = model::testing::Nominal();
  p.servo.bulk_modulus_psi = bulk_modulus_psi;
  return p;
}

TEST(ThesisLinear, IsTheExactOneOfTheReference) {
  // expected.md, row "exact" of (3.18), to the digits shown there.
  const TransferFunction t = ThesisTransferFunction(At(With(110e3)));
  EXPECT_NEAR(t.numerator[0], 4.66159e6, 5.0);
  EXPECT_NEAR(t.denominator[0], 155.847e-6, 0.5e-9);
  EXPECT_NEAR(t.denominator[1], 142.393e-3, 0.5e-6);
  EXPECT_NEAR(t.denominator[2], 191.412, 0.5e-3);
  EXPECT_NEAR(t.denominator[3], 175.624e3, 0.5);
  EXPECT_NEAR(t.denominator[4], 10.8817e6, 50.0);
}

TEST(ThesisLinear, HasThePolesOfTheReference) {
  // expected.md, to the digits shown there.
  const auto expect = [](double bulk_modulus_psi, double slow, double real, double imaginary, double relay) {
    const PoleList poles = Roots(ThesisTransferFunction(At(With(bulk_modulus_psi))).denominator);
    EXPECT_NEAR(poles.items[0].s.real(), slow, 0.05);
    EXPECT_NEAR(poles.items[1].s.real(), relay, 0.05);
    EXPECT_NEAR(poles.items[2].s.real(), real, 0.05);
    EXPECT_NEAR(poles.items[2].s.imag(), imaginary, 0.05);
  };
  expect(110e3, -66.6, 14.5, 1094.1, -876.1);
  expect(230e3, -66.6, -15.9, 1575.1, -883.0);
}

TEST(ThesisLinear, TheFormulasAreTheTransferFunctionOfTheStates) {
  // (B.18) and (G.15), multiplied out by the thesis, against the resolvent of (3.13) to (3.15): to rounding.
  for (const bool stabilizer : {false, true}) {
    for (const bool full_a4 : {false, true}) {
      model::Parameters p = model::testing::Nominal();
      p.stabilizer.enabled = stabilizer;
      const ThesisCoefficients c = At(p, {.full_a4 = full_a4});
      const TransferFunction printed = ThesisTransferFunction(c);
      const TransferFunction states = ToTransferFunction(ThesisSystem(c));
      const double scale = printed.denominator[0];
      ASSERT_EQ(states.denominator.degree, printed.denominator.degree);
      ASSERT_EQ(states.numerator.degree, printed.numerator.degree);
      for (int i = 0; i <= printed.denominator.degree; ++i)
        EXPECT_NEAR(scale * states.denominator[i] / printed.denominator[i], 1.0, 1e-10) << "power " << i;
      for (int i = 0; i <= printed.numerator.degree; ++i)
        EXPECT_NEAR(scale * states.numerator[i] / printed.numerator[i], 1.0, 1e-10) << "power " << i;
    }
  }
}

TEST(ThesisLinear, FullA4IsTheDerivativeOfTheCapillary) {
  EXPECT_NEAR(At(model::testing::Nominal()).a4, 0.2901, 0.5e-4);
  EXPECT_NEAR(At(model::testing::Nominal(), {.full_a4 = true}).a4, 11.87, 0.005);  // errata 13
}

TEST(ThesisLinear, TableIIIAndTableVI) {
  const auto changes = [](const model::Parameters& p) {
    return Routh(ThesisTransferFunction(At(p)).denominator).sign_changes;
  };
  model::Parameters p = With(230e3);
  EXPECT_EQ(changes(p), 0);
  p.servo.underlap_in = 0.001;
  EXPECT_EQ(changes(p), 2);
  EXPECT_EQ(changes(With(110e3)), 2);
  p = With(230e3);
  p.cam.alpha = 0.45;
  p.cam.x3_star_in = 3.38;
  EXPECT_EQ(changes(p), 2);
  p = With(110e3);
  const std::array<model::StabilizerParameters, 3> rows = {{{true, 0.05, 2.5, 20.0, 20.0, 1.4},
                                                            {true, 0.15, 7.5, 98.0, 98.0, 1.4},
                                                            {true, 0.30, 15.0, 100.0, 100.0, 1.4}}};
  const std::array<int, 3> expected = {2, 0, 0};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    p.stabilizer = rows[i];
    EXPECT_EQ(changes(p), expected[i]) << "Table VI row " << i + 1;
  }
}

}  // namespace
}  // namespace servohil::linear
