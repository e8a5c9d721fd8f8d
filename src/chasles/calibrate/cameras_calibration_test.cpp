#include <Eigen/Cholesky>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/calibrate/calibrate_testing.hpp>
#include <chasles/calibrate/cameras_report.hpp>
#include <chasles/calibrate/cross_validation.hpp>
#include <chasles/calibrate/projection_uncertainty.hpp>

namespace chasles::test {
namespace {

struct Scores {
  double nees = 0, rows = 0;          // of all parameters
  double beyond = 0, parameters = 0;  // of 3 sigma, each by itself
  double pixels = 0, expected = 0;    // squares of the projections' differences
};

void score(const CamerasCalibration& found, const std::vector<Camera>& truth, bool is_unique,
           Scores& scores) {
  const CamerasLayout layout = found.layout();
  for (std::size_t c = 0; c < truth.size(); ++c) {
    const auto grid = projection_uncertainty(found.cameras[c], lens_covariance(found, c));
    const auto differences = projection_difference(found.cameras[c], truth[c]);
    for (const PixelUncertainty& one : grid) scores.expected += one.sigma_px * one.sigma_px;
    for (const PixelDifference& one : differences) {
      scores.pixels += one.difference.squaredNorm() / 2;
    }
  }
  if (!is_unique) return;
  const auto [errors, covariance] =
      in_search_coordinates({calibration_errors(found, truth), found.covariance}, found.cameras,
                            truth, [&](std::size_t c) { return layout.lens_row(c); });
  scores.nees += errors.dot(covariance.ldlt().solve(errors));
  scores.rows += static_cast<double>(errors.size());
  const Eigen::VectorXd sigmas = covariance.diagonal().cwiseSqrt();
  scores.parameters += static_cast<double>(errors.size());
  scores.beyond += static_cast<double>((errors.array().abs() > 3 * sigmas.array()).count());
}

// From nothing but corners.
TEST(CamerasCalibration, ErrorsAreThoseOfTheirCovarianceForEachLens) {
  for (const Lens& lens : lenses()) {
    SCOPED_TRACE(name_of(form_of(lens.camera)));
    const std::vector<Camera> truth = {lens.camera};
    const bool is_unique = !has_twin(lens.camera);
    Scores scores;
    constexpr int kRuns = 3;
    for (int run = 0; run < kRuns; ++run) {
      const CamerasCalibration found =
          calibrate_cameras(board_views({.cameras = truth}, static_cast<std::uint64_t>(run)));
      EXPECT_NEAR(found.pixel_sigma, 0.2, 0.01);
      score(found, truth, is_unique, scores);
    }
    if (is_unique) {
      EXPECT_LT(scores.nees / scores.rows, 3);
      EXPECT_GT(scores.nees / scores.rows, 0.25);
    }
    EXPECT_LT(scores.pixels / scores.expected, 1.5);
  }
}

TEST(CamerasCalibration, ErrorsAreThoseOfTheirCovarianceForRigs) {
  Scores scores;
  for (const std::size_t count : {2u, 3u, 4u}) {
    const std::vector<Camera> truth = rig(count);
    for (std::uint64_t run = 0; run < 3; ++run) {
      score(calibrate_cameras(board_views({.cameras = truth}, 100 * count + run)), truth, true,
            scores);
    }
  }
  EXPECT_LT(scores.nees / scores.rows, 1.6);
  EXPECT_GT(scores.nees / scores.rows, 0.5);
  EXPECT_LE(scores.beyond, 0.02 * scores.parameters);
  EXPECT_LT(scores.pixels / scores.expected, 1.7);
}

TEST(CamerasCalibration, HalvesAgreeWithinTheirSigmas) {
  const CamerasInput input = board_views({.cameras = rig(2), .instants = 120}, 5);
  const HalvesComparison halves = compare_halves(input);
  const double chi2 = (halves.difference.array() / halves.sigma.array()).square().mean();
  EXPECT_LT(chi2, 2.5);
  EXPECT_GT(chi2, 0.2);
  EXPECT_NEAR(halves.held_out_rms, 0.2 * std::sqrt(2), 0.02);
  EXPECT_LT(halves.pixels[0], 2.5 * halves.pixels_sigma[0]);
}

// Several models may do for a lens. One that does not is never chosen.
TEST(CamerasCalibration, TheLensIsChosenByViewsThatItHasNotSeen) {
  for (const Camera& camera : {euroc_camera(), fisheye_camera(),
                               lens_of(Distortion::kEucm, {0.62, 1.08}, 320, 1.5).camera}) {
    const LensForm own = form_of(camera);
    CamerasInput input = board_views({.cameras = {camera}}, 11);
    input.lenses.clear();
    const LensChoice choice = choose_lenses(input, {common_lenses()}, true, 2)[0].value();
    EXPECT_EQ(input.lenses, std::vector{choice.lens});
    const auto trial_of = [&](const LensForm& lens) {
      return *std::ranges::find(choice.trials, lens, &LensTrial::lens);
    };
    EXPECT_NEAR(trial_of(own).held_out_rms, 0.2 * std::sqrt(2), 0.01) << name_of(own);
    EXPECT_LE(trial_of(choice.lens).held_out_rms, 1.01 * trial_of(own).held_out_rms);
    EXPECT_LE(choice.lens.parameters(), own.parameters());
  }
}

TEST(CamerasCalibration, ALensThatEndsTooSoonPredictsBadly) {
  CamerasInput input = board_views({.cameras = {fisheye_camera(), euroc_camera()}}, 11);
  input.lenses.clear();
  CamerasInput again = input;
  const auto choices = choose_lenses(input, {common_lenses(), {LensForm{}}}, true, 2);
  EXPECT_GT(choices[0]->trials[0].held_out_rms, 1) << "radtan ends before 90 degrees";
  EXPECT_FALSE(choices[1]) << "there is one";
  const auto same = choose_lenses(again, {common_lenses(), {LensForm{}}}, true, 1);
  EXPECT_EQ(again.lenses, input.lenses);
  for (std::size_t i = 0; i < choices[0]->trials.size(); ++i) {
    EXPECT_EQ(same[0]->trials[i].held_out_rms, choices[0]->trials[i].held_out_rms);
  }
}

// Halves may determine what all views with all unknowns do not.
TEST(CamerasCalibration, ALensWithoutACalibrationIsGivenUp) {
  CamerasInput input = board_views({.cameras = rig(2)}, 11);
  input.lenses.clear();
  const std::vector<LensForm> candidates = {{Distortion::kRadtan, 4}, {Distortion::kRadtan, 5}};
  int calls = 0;
  const auto choices =
      calibrate_with_chosen_lenses(input, {candidates, {LensForm{}}}, true, 1, [&] {
        if (++calls == 1) throw UndeterminedError("the first");
      });
  EXPECT_EQ(calls, 2);
  EXPECT_EQ(input.lenses[0], candidates[1]);
  EXPECT_EQ(choices[0]->lens, candidates[1]);
  EXPECT_EQ(choices[0]->trials[0].fault, "the first");
  input.lenses.clear();
  EXPECT_THROW(calibrate_with_chosen_lenses(input, {candidates, {LensForm{}}}, true, 1,
                                            [] { throw UndeterminedError("each"); }),
               UndeterminedError);
}

// However often a view is there, it says what it says once.
TEST(CamerasCalibration, ViewsThatAreAlikeCountOnce) {
  const CamerasInput input = board_views({.cameras = rig(1), .instants = 12}, 6);
  CamerasInput often = input;
  often.views.clear();
  for (const TargetView& view : input.views) {
    for (int i = 0; i < 30; ++i) {
      often.views.push_back(view);
      often.views.back().time = view.time * 30 + std::chrono::seconds(i);
    }
  }
  const CamerasCalibration once = calibrate_cameras(input), many = calibrate_cameras(often);
  EXPECT_EQ(many.pieces, once.pieces);
  const Eigen::VectorXd ratio =
      (many.covariance.diagonal().array() / once.covariance.diagonal().array()).sqrt();
  EXPECT_GT(ratio.minCoeff(), 0.5) << ratio.transpose();
  EXPECT_LT(ratio.maxCoeff(), 2) << ratio.transpose();
  EXPECT_FALSE(few_pieces(many.pieces).empty());
}

TEST(CamerasCalibration, SaysWhatIsMissing) {
  const auto fault_of = [](const CamerasInput& input) -> std::string {
    try {
      calibrate_cameras(input);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  CamerasInput few = board_views({.cameras = rig(1), .instants = 2}, 1);
  EXPECT_NE(fault_of(few).find("cam0: found 2 views"), std::string::npos) << fault_of(few);
  // Two cameras that never see the board at the same time.
  CamerasInput apart = board_views({.cameras = rig(2), .instants = 30}, 2);
  for (TargetView& view : apart.views) view.time += std::chrono::nanoseconds(view.camera);
  EXPECT_NE(fault_of(apart).find("cam1: found 0 instants"), std::string::npos) << fault_of(apart);
  CamerasInput wrong = board_views({.cameras = rig(1)}, 4);
  wrong.views[0].ids[0] = 1000;
  EXPECT_NE(fault_of(wrong).find("from 0 to 143"), std::string::npos);
  wrong.views[0].ids[0] = 0;
  wrong.views[0].pixels[0].x() = kNaN;
  EXPECT_NE(fault_of(wrong).find("not finite"), std::string::npos);
}

}  // namespace
}  // namespace chasles::test
