#include "base/nearest_name.hpp"

#include <gtest/gtest.h>

namespace servohil::base {
namespace {

TEST(EditDistance, CountsInsertionsDeletionsAndSubstitutions) {
  EXPECT_EQ(EditDistance("", ""), 0U);
  EXPECT_EQ(EditDistance("", "abc"), 3U);
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3U);  // k-s, e-i, +g: the textbook's example
  EXPECT_EQ(EditDistance("flaw", "lawn"), 2U);       // -f, +n
}

TEST(EditDistance, TakesNoAccountOfCase) {
  EXPECT_EQ(EditDistance("gov_command", "GOV_Command"), 0U);
}

TEST(NearestName, FindsAMistypedName) {
  const std::vector<std::string> names{"SERVO_Position", "SERVO_Pressures", "GOV_Command"};
  EXPECT_EQ(NearestName("GOV_Comand", names), "GOV_Command");
  EXPECT_EQ(NearestName("SERVO_Pressure", names), "SERVO_Pressures");
  EXPECT_EQ(NearestName("servo_position", names), "SERVO_Position");
}

TEST(NearestName, IsEmptyWhenMoreThanAThirdOfTheLettersIsWrong) {
  const std::vector<std::string> names{"SERVO_Position"};
  EXPECT_EQ(NearestName("Engine_Speed", names), "");
  EXPECT_EQ(NearestName("", names), "");
  EXPECT_EQ(NearestName("X3", std::vector<std::string>{"Y8"}), "");  // nothing of it is left
  EXPECT_EQ(NearestName("anything", std::vector<std::string>{}), "");
}

}  // namespace
}  // namespace servohil::base
