#include <cmath>
#include <sstream>

#include <nlohmann/json.hpp>

#include "cli_test.hpp"

// Velocities with a time offset to the frames.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

constexpr std::int64_t kLate = 60'000'000;  // [ns]

// Writes "rec", and "late" with the velocities stamped late by kLate.
void simulate_late(const Scratch& folder) {
  const Outcome made = chasles(folder,
                               "simulate street-ins -o rec --quiet --set route=RL "
                               "--set block_length=60 --set block_width=60");
  ASSERT_EQ(made.code, 0) << made.err;
  std::filesystem::copy(folder / "rec", folder / "late");
  std::istringstream rows(slurp(folder / "rec/velocities.csv"));
  std::string line, late;
  std::getline(rows, line);
  late = line + "\n";
  while (std::getline(rows, line)) {
    const std::size_t comma = line.find(',');
    late += std::to_string(std::stoll(line.substr(0, comma)) + kLate) + line.substr(comma) + "\n";
  }
  std::ofstream(folder / "late/velocities.csv") << late;
}

Json run(const Scratch& folder, const std::string& arguments) {
  const Outcome outcome = chasles(folder, "run " + arguments + " --json --quiet");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  return outcome.code == 0 ? Json::parse(outcome.out) : Json();
}

TEST(TimeOffset, OfVelocitiesIsFoundSaidAndCorrected) {
  const Scratch folder;
  simulate_late(folder);
  const Json as_stamped = run(folder, "late"), found = run(folder, "late --set time_offset=auto");
  EXPECT_EQ(as_stamped["noise"]["time_offset"], 0);
  EXPECT_NEAR(found["noise"]["time_offset"].get<double>(), 0.06, 0.01);
  expect_part(found["remarks"].dump(), "are stamped late by");
  expect_part(found["remarks"].dump(), "their time stamps are corrected");
  const Json right = run(folder, "rec");
  const auto ate = [](const Json& figures) { return figures["ate_m"].get<double>(); };
  EXPECT_GT(ate(as_stamped), 1.2 * ate(right));
  EXPECT_LT(ate(found), 1.1 * ate(right));
  const Json untouched = run(folder, "rec --set time_offset=auto");
  EXPECT_EQ(untouched["noise"]["time_offset"], 0);
  expect_part(untouched["remarks"].dump(), "their time stamps are not corrected");
}

TEST(TimeOffset, ThatIsStatedIsTakenByEveryEstimator) {
  const Scratch folder;
  simulate_late(folder);
  for (const char* estimator : {"filter", "batch", "window:5"}) {
    const std::string by = std::string(" --estimator ") + estimator;
    const Json right = run(folder, "rec --stop 6" + by);
    const Json stated = run(folder, "late --stop 6 --set time_offset=0.06" + by);
    // Only the sample at the first frame differs: it is interpolated.
    EXPECT_NEAR(stated["ate_m"].get<double>(), right["ate_m"].get<double>(), 0.01) << estimator;
  }
  expect_error(chasles(folder, "run late --quiet --set time_offset=0.6"), 1, "time_offset");
}

TEST(TimeOffset, OfVelocitiesIsAFindingOfTheCheck) {
  const Scratch folder;
  simulate_late(folder);
  const Json report = Json::parse(chasles(folder, "check late --json").out);
  expect_part(report["findings"].dump(), "they are stamped late by");
  expect_part(report["findings"].dump(), "time_offset=0.06");
  const Json right = Json::parse(chasles(folder, "check rec --json").out);
  EXPECT_EQ(right["findings"].dump().find("stamped"), std::string::npos);
}

}  // namespace
}  // namespace chasles::test
