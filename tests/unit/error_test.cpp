#include "base/error.hpp"

#include <gtest/gtest.h>

namespace calor {
namespace {

TEST(Errors, SayPlaceProblemAndCureInOneLine) {
  const Error e(Fault::bad_case, {"weld.toml", 14, 9}, "'conductivty' is not a key of [material.steel]",
                "did you mean 'conductivity'?");
  EXPECT_STREQ(e.what(),
               "weld.toml:14:9: 'conductivty' is not a key of [material.steel]: did you mean 'conductivity'?");
  EXPECT_EQ(e.problem(), "'conductivty' is not a key of [material.steel]");
  EXPECT_EQ(e.cure(), "did you mean 'conductivity'?");
  EXPECT_EQ(e.location().line, 14);
}

TEST(Errors, LeaveOutWhatIsUnknown) {
  EXPECT_STREQ(Error(Fault::numbers, "it diverges", "").what(), "it diverges");
  EXPECT_STREQ(Error(Fault::numbers, "it diverges", "take smaller steps").what(), "it diverges: take smaller steps");
  EXPECT_EQ((SourceLocation{"a.csv", 3, 0}.text()), "a.csv:3");
  EXPECT_EQ((SourceLocation{"a.csv", 0, 0}.text()), "a.csv");
  EXPECT_EQ(SourceLocation{}.text(), "");
}

TEST(Errors, HaveTheExitCodeOfTheCommandAsFault) {
  EXPECT_EQ(static_cast<int>(Error(Fault::command, "a", "b").fault()), 2);
  EXPECT_EQ(static_cast<int>(Error(Fault::bad_case, "a", "b").fault()), 3);
  EXPECT_EQ(static_cast<int>(Error(Fault::file, "a", "b").fault()), 4);
  EXPECT_EQ(static_cast<int>(Error(Fault::numbers, "a", "b").fault()), 5);
}

}  // namespace
}  // namespace calor
