#include "model/cam.hpp"

#include <gtest/gtest.h>

namespace servohil::model {
namespace {

CamParameters TwoSlope() {
  CamParameters p;
  p.shape = CamShape::kTwoSlope;
  return p;
}

TEST(Cam, SingleSlopeIsTheLineOfEquation2_15) {
  const Cam cam{CamParameters{}};
  EXPECT_DOUBLE_EQ(cam.At(4.0), 4.18);  // 0.32 * 4 + 2.90
  EXPECT_DOUBLE_EQ(cam.SlopeAt(-1.0), 0.32);
}

TEST(Cam, TwoSlopesMeetWhereErrata8Says) {
  const Cam cam(TwoSlope());
  EXPECT_NEAR(cam.knee_x3_in(), 2.8444, 5e-5);  // (3.38 - 2.10) / (0.90 - 0.45)
  EXPECT_DOUBLE_EQ(cam.At(2.0), 0.90 * 2.0 + 2.10);
  EXPECT_DOUBLE_EQ(cam.At(4.0), 0.45 * 4.0 + 3.38);
}

TEST(Cam, TwoSlopesAreContinuousAtTheKnee) {
  const Cam cam(TwoSlope());
  const double knee = cam.knee_x3_in();
  EXPECT_NEAR(cam.At(knee - 1e-12), cam.At(knee), 2e-12);  // slope 0.9 over 1e-12, and rounding
}

}  // namespace
}  // namespace servohil::model
