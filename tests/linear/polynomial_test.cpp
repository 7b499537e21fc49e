#include "linear/polynomial.hpp"

#include <gtest/gtest.h>

namespace servohil::linear {
namespace {

TEST(Polynomial, AddsAndMultiplies) {
  const Polynomial a{1.0, 2.0};        // s + 2
  const Polynomial b{3.0, 0.0, -1.0};  // 3 s² - 1
  const Polynomial sum = a + b;        // 3 s² + s + 1
  EXPECT_EQ(sum.degree, 2);
  EXPECT_EQ(sum[0], 3.0);
  EXPECT_EQ(sum[1], 1.0);
  EXPECT_EQ(sum[2], 1.0);
  const Polynomial product = a * b;  // 3 s³ + 6 s² - s - 2
  EXPECT_EQ(product.degree, 3);
  EXPECT_EQ(product[0], 3.0);
  EXPECT_EQ(product[1], 6.0);
  EXPECT_EQ(product[2], -1.0);
  EXPECT_EQ(product[3], -2.0);
  EXPECT_EQ(product.At({0.0, 1.0}), std::complex<double>(-8.0, -4.0));
}

TEST(Roots, OfAProductAreItsFactors) {
  // (s + 0.1)(s + 50)(s² + 20 s + 1.1e6), as far apart as a servomotor's
  const Polynomial p = Polynomial{1.0, 0.1} * Polynomial{1.0, 50.0} * Polynomial{1.0, 20.0, 1.1e6};
  const PoleList roots = Roots(p);
  ASSERT_EQ(roots.size, 4);
  // Companion matrix of a polynomial scaled to roots about 1: 1e-16 of the largest, 1e-11 of the smallest.
  EXPECT_NEAR(roots.items[0].s.real(), -0.1, 1e-10);
  EXPECT_NEAR(roots.items[1].s.real(), -50.0, 1e-9);
  EXPECT_NEAR(roots.items[2].s.real(), -10.0, 1e-9);
  EXPECT_NEAR(roots.items[2].s.imag(), std::sqrt(1.1e6 - 100.0), 1e-9);
  EXPECT_EQ(roots.items[3].s, std::conj(roots.items[2].s));
  EXPECT_NEAR(roots.items[2].Damping(), 10.0 / std::sqrt(1.1e6), 1e-12);
}

TEST(Roots, LeadingZerosAreNoneAndTrailingOnesAreAtZero) {
  const PoleList roots = Roots({0.0, 2.0, -6.0, 0.0, 0.0});
  ASSERT_EQ(roots.size, 3);
  EXPECT_EQ(roots.items[0].s, 0.0);
  EXPECT_EQ(roots.items[1].s, 0.0);
  EXPECT_NEAR(roots.items[2].s.real(), 3.0, 1e-14);
  EXPECT_EQ(Roots({5.0}).size, 0);
}

}  // namespace
}  // namespace servohil::linear
