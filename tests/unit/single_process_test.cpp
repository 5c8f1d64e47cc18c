// What MPI is told of a process that nobody has launched.
#include "base/single_process.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace calor {
namespace {

TEST(SingleProcess, LeavesTheEnvironmentAsItWas) {
  if (std::getenv("PMIX_RANK")) GTEST_SKIP() << "launched";
  setenv("OMPI_MCA_btl", "self,vader", 1);
  unsetenv("OMPI_MCA_pml");
  {
    const SingleProcess alone;
    EXPECT_STREQ(std::getenv("OMPI_MCA_btl"), "self,vader");
    EXPECT_STREQ(std::getenv("OMPI_MCA_pml"), "ob1");
  }
  EXPECT_STREQ(std::getenv("OMPI_MCA_btl"), "self,vader");
  EXPECT_EQ(std::getenv("OMPI_MCA_pml"), nullptr);
  unsetenv("OMPI_MCA_btl");
}

TEST(SingleProcess, IsNotExpectedOfARankThatWasLaunched) {
  setenv("PMI_RANK", "1", 1);
  unsetenv("OMPI_MCA_pml");
  const SingleProcess alone;
  EXPECT_EQ(std::getenv("OMPI_MCA_pml"), nullptr);
  unsetenv("PMI_RANK");
}

}  // namespace
}  // namespace calor
