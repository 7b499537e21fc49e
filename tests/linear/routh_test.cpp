#include <gtest/gtest.h>

#include <random>

#include "linear/transfer_function.hpp"

namespace servohil::linear {
namespace {

TEST(Routh, IsTheArrayOfTheThesis) {
  // (B.19), as printed; c1 is 176.1e3 - 142.9e-3 10.89e6 / -0.6803, of which the thesis prints the first
  // term.
  const RouthArray array = Routh({155.9e-6, 142.9e-3, 191.44, 176.1e3, 10.89e6});
  ASSERT_EQ(array.row_count, 5);
  EXPECT_NEAR(array.First(2), -680.3e-3, 0.05e-3);
  EXPECT_NEAR(array.First(3), 2.4636e6, 50.0);
  EXPECT_NEAR(array.First(4), 10.89e6, 1.0);
  EXPECT_EQ(array.sign_changes, 2);
  EXPECT_FALSE(array.Stable());
}

TEST(Routh, CountsTheRootsInTheRightHalfPlane) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> real(-3.0, 3.0);
  for (int i = 0; i < 1000; ++i) {
    Polynomial p{1.0};
    int right = 0;
    for (int pair = 0; pair < 2; ++pair) {
      const double re = real(random);
      const double im = real(random);
      p = p * Polynomial{1.0, -2.0 * re, re * re + im * im};
      right += re > 0.0 ? 2 : 0;
    }
    const double single = real(random);
    p = p * Polynomial{1.0, -single};
    right += single > 0.0 ? 1 : 0;
    EXPECT_EQ(Routh(p).sign_changes, right) << "polynomial " << i;
  }
}

TEST(Routh, AZeroElementIsASmallPositiveNumber) {
  // s⁴ + s³ + 2 s² + 2 s + 3: the row of s² begins with 2 - 2 = 0; roots 0.41 ± 1.29j, -0.91 ± 0.90j.
  const RouthArray array = Routh({1.0, 1.0, 2.0, 2.0, 3.0});
  EXPECT_TRUE(array.zero_element);
  EXPECT_FALSE(array.zero_row);
  EXPECT_EQ(array.sign_changes, 2);
}

TEST(Routh, ARowOfZerosTakesTheAuxiliaryPolynomial) {
  // (s² + 4)(s + 1)(s + 2) = s⁴ + 3 s³ + 6 s² + 12 s + 8: roots ± 2j, none to the right.
  const RouthArray array = Routh({1.0, 3.0, 6.0, 12.0, 8.0});
  EXPECT_TRUE(array.zero_row);
  EXPECT_EQ(array.sign_changes, 0);
  EXPECT_FALSE(array.Stable()) << "on the limit is not stable";
  // The same with (s - 1): symmetric about the origin, (s² - 1)(s² + 4) has one root to the right.
  EXPECT_EQ(Routh(Polynomial{1.0, 0.0, -1.0} * Polynomial{1.0, 0.0, 4.0}).sign_changes, 1);
}

TEST(Routh, OfLowDegrees) {
  EXPECT_TRUE(Routh({1.0, 2.0}).Stable());
  EXPECT_EQ(Routh({1.0, -2.0}).sign_changes, 1);
  EXPECT_TRUE(Routh({1.0, 2.0, 3.0}).Stable());
  EXPECT_FALSE(Routh({1.0, 0.0, 3.0}).Stable()) << "undamped";
}

}  // namespace
}  // namespace servohil::linear
