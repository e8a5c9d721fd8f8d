#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/many/batch_difference.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

Json record(const char* name, const char* verdict, const Json& sigma) {
  return {{"name", name}, {"verdict", verdict}, {"worst_sigma_m", sigma}};
}

TEST(BatchDifference, PairsRecordingsByTheirNames) {
  const std::vector<Json> before = {record("a", "use", 0.1), record("b", "check", 0.1),
                                    record("c", "no", nullptr), record("d", "use", 0.2)};
  const std::vector<Json> now = {record("a", "no", nullptr), record("b", "use", 0.2),
                                 record("c", "check", 0.3), record("e", "use", 0.1)};
  const Json difference = batch_difference(before, now);
  EXPECT_EQ(difference.at("worse").dump(), R"([{"name":"a","before":"use","now":"no"}])");
  EXPECT_EQ(
      difference.at("better").dump(),
      R"([{"name":"b","before":"check","now":"use"},{"name":"c","before":"no","now":"check"}])");
  EXPECT_EQ(difference.at("only_before"), Json::array({"d"}));
  EXPECT_EQ(difference.at("only_now"), Json::array({"e"}));
  const Json& sigma = difference.at("figures").at("worst_sigma_m");
  EXPECT_EQ(sigma.at("pairs"), 1);
  EXPECT_NEAR(sigma.at("ratio").get<double>(), 2, 1e-12);
  EXPECT_TRUE(sigma.at("low").is_null()) << "one pair has no scatter";
}

TEST(BatchDifference, TheIntervalIsThatOfTheMeanOfTheLogarithms) {
  const std::vector<Json> before = {record("a", "use", 1), record("b", "use", 1),
                                    record("c", "use", 1), record("d", "use", 1)};
  const std::vector<Json> now = {
      record("a", "use", std::exp(0.1)), record("b", "use", std::exp(0.3)),
      record("c", "use", std::exp(0.1)), record("d", "use", std::exp(0.3))};
  const Json sigma = batch_difference(before, now).at("figures").at("worst_sigma_m");
  // Mean 0.2, standard deviation 0.2 / sqrt(3), of the mean 0.1 / sqrt(3); Student's t of 3 degrees
  // of freedom, from tables.
  constexpr double t = 3.18244630528371;
  EXPECT_NEAR(std::log(sigma.at("ratio").get<double>()), 0.2, 1e-12);
  EXPECT_NEAR(std::log(sigma.at("high").get<double>()), 0.2 + t * 0.1 / std::sqrt(3), 1e-12);
  EXPECT_NEAR(std::log(sigma.at("low").get<double>()), 0.2 - t * 0.1 / std::sqrt(3), 1e-12);
}

}  // namespace
}  // namespace chasles
