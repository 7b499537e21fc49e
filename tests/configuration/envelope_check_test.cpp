#include "configuration/envelope_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.hpp"
#include "support/default_setup.hpp"

namespace servohil::configuration {
namespace {

using ::testing::HasSubstr;

std::string ResultOf(const std::vector<std::string>& settings) {
  const Configuration c = LoadConfiguration(testing::kConfigurationFile, settings);
  try {
    return CheckEnvelope(c, model::Derived(c.model));
  } catch (const base::UsageError& error) {
    return std::string("refused: ") + error.what();
  }
}

TEST(EnvelopeCheck, AcceptsWhatIsResolvedWithoutAWord) {
  EXPECT_EQ(ResultOf({}), "");
  EXPECT_EQ(ResultOf({"stabilizer.enabled=true", "friction.coulomb_psi=5"}), "");
  EXPECT_EQ(ResultOf({"oil.air_fraction=0.05", "oil.dissolution_pressure_psi=150"}), "");
  EXPECT_EQ(ResultOf({"model.physics=thesis"}), "");
  // 42,500 1/s near the lower stop, beyond RK4's 27,850 (expected.md, last section): sub-steps resolve it.
  EXPECT_EQ(ResultOf({"model.physics=thesis", "stabilizer.enabled=true", "servo.bulk_modulus_psi=230000"}),
            "");
}

TEST(EnvelopeCheck, RefusesAChamberOfNoVolumeWithItsNumbersAndKeys) {
  // 0.1 in³ under the piston at the lower stop: 1e8 1/s, a thousand times what the nominal 30 in³ have.
  const std::string refusal = ResultOf({"servo.piston_volume_at_zero_in3=0.1"});
  EXPECT_THAT(refusal, HasSubstr("refused: "));
  EXPECT_THAT(refusal, HasSubstr("at x3 = 0 in, P3 = "));
  EXPECT_THAT(refusal, HasSubstr("the chamber under the piston changes at "));
  EXPECT_THAT(refusal, HasSubstr("48 allowed"));
  EXPECT_THAT(refusal, HasSubstr("raise servo.piston_volume_at_zero_in3 = 0.1"));
  EXPECT_EQ(refusal.find('\n'), std::string::npos);
}

TEST(EnvelopeCheck, OnlyWarnsAboutTheSourcesEquations) {
  const std::string warning = ResultOf({"servo.piston_volume_at_zero_in3=0.1", "model.physics=thesis"});
  EXPECT_THAT(warning, HasSubstr("physics \"thesis\" is not resolved"));
  EXPECT_THAT(warning, HasSubstr("or model.physics = \"full\""));
}

}  // namespace
}  // namespace servohil::configuration
