#include "rt/latency_histogram.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace servohil::rt {
namespace {

TEST(LatencyHistogram, IsEmptyAtFirst) {
  const LatencyHistogram h;
  EXPECT_EQ(h.Count(), 0U);
  EXPECT_EQ(h.QuantileNs(0.5), 0U);
}

/// Durations of every magnitude: uniform in the number of bits, dense where the histogram is exact, and some
/// that clocks that step back would give.
rc::Gen<std::int64_t> AnyDuration() {
  const auto of_any_magnitude = rc::gen::exec([] {
    const auto bits = *rc::gen::inRange(0, 63);
    return static_cast<std::int64_t>(*rc::gen::arbitrary<std::uint64_t>() >> (63 - bits) >> 1);
  });
  return rc::gen::weightedOneOf<std::int64_t>({{6, of_any_magnitude},
                                               {3, rc::gen::inRange<std::int64_t>(0, 64)},
                                               {1, rc::gen::inRange<std::int64_t>(-5, 1)}});
}

/// Any distribution: any durations, a few of them many times.
rc::Gen<std::vector<std::int64_t>> AnyDurations() {
  const auto any = rc::gen::exec([] {
    const auto kinds = *rc::gen::nonEmpty(rc::gen::container<std::vector<std::int64_t>>(AnyDuration()));
    std::vector<std::int64_t> durations;
    for (const std::int64_t kind : kinds)
      durations.insert(durations.end(), static_cast<std::size_t>(*rc::gen::inRange(1, 50)), kind);
    return durations;
  });
  return rc::gen::resize(rc::kNominalSize, any);  // the whole range from the first case on
}

/// The smallest duration with at least `fraction` of all at or below it.
std::uint64_t ExactQuantile(const std::vector<std::uint64_t>& sorted, double fraction) {
  const double rank = std::ceil(fraction * static_cast<double>(sorted.size()));
  return sorted[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

RC_GTEST_PROP(LatencyHistogramProperty, QuantilesAreHighByAtMostOne32ndAndExactBelow32Ns, ()) {
  LatencyHistogram h;
  std::vector<std::uint64_t> exact;
  for (const std::int64_t ns : *AnyDurations()) {
    h.Record(ns);
    exact.push_back(static_cast<std::uint64_t>(std::max<std::int64_t>(ns, 0)));
  }
  std::sort(exact.begin(), exact.end());
  RC_ASSERT(h.Count() == exact.size());
  RC_ASSERT(h.MaxNs() == exact.back());
  RC_ASSERT(h.QuantileNs(1.0) == exact.back());
  const double any_fraction = *rc::gen::inRange(0, 1'000'001) / 1e6;
  for (const double fraction : {any_fraction, 0.0, 0.5, 0.99, 0.999}) {
    const std::uint64_t want = ExactQuantile(exact, fraction);
    const std::uint64_t got = h.QuantileNs(fraction);
    RC_ASSERT(got >= want);
    RC_ASSERT(got - want <= want / 32);  // 0 below 32 ns
    RC_ASSERT(got <= exact.back());
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
