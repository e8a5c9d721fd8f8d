#include <gtest/gtest.h>

#include <chasles/pipeline/delayed_bias.hpp>

namespace chasles {
namespace {

// Front end and estimator take turns: image k has the bias after frame k - kLead.
TEST(DelayedBias, ComesSoManyImagesLater) {
  DelayedBias biases;
  for (std::size_t k = 0; k < 10; ++k) {
    ASSERT_TRUE(biases.known());
    const double expected =
        k < DelayedBias::kLead ? 0.0 : 1.0 + static_cast<double>(k - DelayedBias::kLead);
    EXPECT_EQ(biases.next(), Eigen::Vector3d::Constant(expected));
    biases.pass();
    biases.note(Eigen::Vector3d::Constant(1.0 + static_cast<double>(k)));
  }
}

TEST(DelayedBias, LetsTheFrontEndBeSoFarAhead) {
  DelayedBias biases;
  for (std::size_t k = 0; k < DelayedBias::kLead; ++k) {
    ASSERT_TRUE(biases.known());
    biases.pass();
  }
  EXPECT_FALSE(biases.known());
  biases.note(Eigen::Vector3d::Ones());
  ASSERT_TRUE(biases.known());
  EXPECT_EQ(biases.next(), Eigen::Vector3d::Ones());
}

}  // namespace
}  // namespace chasles
