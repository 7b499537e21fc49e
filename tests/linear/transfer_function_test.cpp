#include "linear/transfer_function.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "linear/linearization.hpp"
#include "model/nominal.hpp"

namespace servohil::linear {
namespace {

LinearSystem Servo(bool stabilizer) {
  model::Parameters p = model::testing::Nominal();
  p.stabilizer.enabled = stabilizer;
  const model::Derived d(p);
  return Linearize(d, model::SteadyStateAt(d, 4.0)).system;
}

TEST(TransferFunction, IsTheResolventAtEveryFrequency) {
  for (const bool stabilizer : {false, true}) {
    const LinearSystem system = Servo(stabilizer);
    const TransferFunction t = ToTransferFunction(system);
    EXPECT_EQ(t.numerator.degree, stabilizer ? 1 : 0)
        << "no numerator dynamics but the stabilizer's, (3.12), (5.9)";
    for (double w = 0.01; w < 1e5; w *= 1.7) {
      const std::complex<double> s(0.0, w);
      Eigen::MatrixXcd m = -system.A.cast<std::complex<double>>();
      m.diagonal().array() += s;
      const Eigen::VectorXcd b = system.B.cast<std::complex<double>>();
      const std::complex<double> exact = m.fullPivLu().solve(b)[0];
      const std::complex<double> ours = t.numerator.At(s) / t.denominator.At(s);
      // LU of a matrix in in and psi loses up to 1e6 of the 1e-16.
      EXPECT_LT(std::abs(ours / exact - 1.0), 1e-9) << w << " rad/s";
    }
  }
}

TEST(TransferFunction, ItsRootsAreTheEigenvalues) {
  const LinearSystem system = Servo(true);
  const PoleList poles = Poles(system);
  const PoleList roots = Roots(ToTransferFunction(system).denominator);
  ASSERT_EQ(roots.size, poles.size);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_LT(std::abs(roots.items[i].s / poles.items[i].s - 1.0), 1e-9) << "pole " << i;
}

}  // namespace
}  // namespace servohil::linear
