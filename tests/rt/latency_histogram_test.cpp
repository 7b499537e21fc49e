#include "servohil/rt/latency_histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace servohil::rt {
namespace {

TEST(LatencyHistogram, IsEmptyAtFirst) {
  const LatencyHistogram h;
  EXPECT_EQ(h.Count(), 0U);
  EXPECT_EQ(h.QuantileNs(0.5), 0U);
}

TEST(LatencyHistogram, QuantilesAreHighByAtMostOne32ndOfTheExactOnes) {
  std::mt19937_64 random(7);                                   // any seed
  std::uniform_real_distribution<double> exponent(0.0, 35.0);  // 1 ns to 30 s
  for (int round = 0; round < 50; ++round) {
    LatencyHistogram h;
    std::vector<std::uint64_t> exact;
    for (int i = 0; i < 1'000; ++i) {
      const auto ns = static_cast<std::uint64_t>(std::exp2(exponent(random)));
      exact.push_back(ns);
      h.Record(static_cast<std::int64_t>(ns));
    }
    std::sort(exact.begin(), exact.end());
    for (const double q : {0.001, 0.1, 0.5, 0.9, 0.99, 0.999, 1.0}) {
      const std::uint64_t want = exact[static_cast<std::size_t>(std::ceil(q * 1'000.0)) - 1];
      EXPECT_GE(h.QuantileNs(q), want);
      EXPECT_LE(static_cast<double>(h.QuantileNs(q)), static_cast<double>(want) * (1.0 + 1.0 / 32.0));
    }
    EXPECT_EQ(h.MaxNs(), exact.back());
  }
}

TEST(LatencyHistogram, TakesAnyDuration) {
  LatencyHistogram h;
  h.Record(-5);
  h.Record(INT64_MAX);
  EXPECT_EQ(h.Count(), 2U);
  EXPECT_EQ(h.QuantileNs(0.5), 0U) << "negative counts as 0";
  EXPECT_EQ(h.QuantileNs(1.0), static_cast<std::uint64_t>(INT64_MAX));
}

}  // namespace
}  // namespace servohil::rt
