#include "model/load_curve.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "nominal.hpp"

namespace servohil::model {
namespace {

/// FTABLE of Appendix E, as written: a scan over the table.
double Scan(const std::vector<LoadCurve::Point>& t, double x) {
  std::size_t i = 0;
  while (i + 2 < t.size() && x >= t[i + 1].x3_in) ++i;
  return t[i].p3_psi + (x - t[i].x3_in) * (t[i + 1].p3_psi - t[i].p3_psi) / (t[i + 1].x3_in - t[i].x3_in);
}

TEST(LoadCurve, HasTheValuesOfItsRows) {
  const LoadCurve load = testing::ThesisLoad();
  for (std::size_t i = 0; i < load.size(); ++i) {
    EXPECT_NEAR(load.PressureAt(load[i].x3_in), load[i].p3_psi, 1e-12) << "row " << i;
  }
  EXPECT_DOUBLE_EQ(load.PressureAt(4.1), 103.0 - 0.1 * 48.0);
}

TEST(LoadCurve, ExtendsItsEndSegments) {
  const LoadCurve load = testing::ThesisLoad();
  EXPECT_NEAR(load.PressureAt(0.0), 67.5 + 4.0 * 4.0, 1e-12);  // 16 psi/in below 1 in
  EXPECT_NEAR(load.PressureAt(9.0), 103.0 - 8.0, 1e-12);       // -8 psi/in above 8 in
  EXPECT_NEAR(load.SlopeAt(100.0), -8.0, 1e-12);
}

TEST(LoadCurve, FindsTheSegmentThatAScanFinds) {
  std::mt19937 random(1);  // any seed: the property holds for every table
  std::uniform_real_distribution<double> gap(1e-4, 1.0);
  std::uniform_int_distribution<std::size_t> size(2, LoadCurve::kMaxPoints);
  for (int table = 0; table < 200; ++table) {
    std::vector<LoadCurve::Point> points;
    double x = gap(random) - 0.5;
    for (std::size_t n = size(random); n > 0; --n) {
      points.push_back({x, 100.0 * gap(random)});
      x += gap(random) * gap(random) * gap(random);  // narrow segments beside wide ones
    }
    const LoadCurve load(points);
    std::uniform_real_distribution<double> anywhere(points.front().x3_in - 1.0, points.back().x3_in + 1.0);
    for (int i = 0; i < 200; ++i) {
      const double at =
          i % 2 == 0 ? anywhere(random) : points[static_cast<std::size_t>(i) % points.size()].x3_in;
      EXPECT_NEAR(load.PressureAt(at), Scan(points, at), 1e-9 * (1.0 + std::fabs(Scan(points, at))));
    }
  }
}

TEST(LoadCurve, ToleratesWhatIsNotANumber) {
  const LoadCurve load = testing::ThesisLoad();
  EXPECT_TRUE(std::isnan(load.PressureAt(std::nan(""))));
  EXPECT_TRUE(std::isinf(load.PressureAt(-INFINITY)));
}

}  // namespace
}  // namespace servohil::model
