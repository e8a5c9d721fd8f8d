#include <gtest/gtest.h>

#include <chasles/filter/testing.hpp>
#include <chasles/smooth/terms/calibrated_costs_detail.hpp>
#include <chasles/smooth/terms/cost_testing.hpp>

namespace chasles {
namespace {

using namespace smooth_detail;
using test::agree;
using test::Blocks;
using test::expect_numeric;
using test::Random;
using test::residual;

// The parts of a calibration that are estimated.
struct Parts {
  bool extrinsics = true, time_offset = true, lens = true, readout = true;
};

Camera rolling_camera(Distortion distortion, double readout) {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 400;
  camera.cx = 320;
  camera.cy = 240;
  camera.distortion = distortion;
  if (distortion == Distortion::kRadtan) camera.coefficients = {-0.2, 0.05, 1e-3, -2e-3};
  if (distortion == Distortion::kEquidistant) camera.coefficients = {-0.01, 0.02, -0.01, 0.003};
  camera.cam_T_imu.R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  camera.cam_T_imu.p = Eigen::Vector3d(0.03, 0.02, -0.01);
  camera.shutter.readout = readout;
  return camera;
}

Calibration calibration_with(const Camera& camera, const Parts& parts) {
  Calibration calibration;
  if (parts.extrinsics) calibration.imu_T_camera = {camera.cam_T_imu.inverse()};
  if (parts.time_offset) calibration.time_offset = 0.004;
  if (parts.lens || parts.readout) {
    Intrinsics one = intrinsics_of(camera);
    one.has_lens = parts.lens;
    one.has_readout = parts.readout && camera.shutter.is_rolling();
    calibration.intrinsics = {one};
  }
  return calibration;
}

std::vector<std::vector<double>> numbers_of(const Calibration& calibration) {
  const CalibrationBlocks blocks(calibration);
  std::vector<double> all(static_cast<std::size_t>(blocks.numbers()));
  write_calibration(calibration, all.data());
  std::vector<std::vector<double>> numbers;
  for (const auto& block : blocks.all()) {
    const auto from = all.begin() + block.number;
    numbers.emplace_back(from, from + block.numbers);
  }
  return numbers;
}

ReadoutMotion some_readout(Random& random) {
  return {.rate = random.normal_vector(3),
          .rate_change = 3 * random.normal_vector(3),
          .velocity = random.normal_vector(3),
          .acceleration = 2 * random.normal_vector(3)};
}

std::vector<double> motion_near(Random& random) {
  std::vector<double> x(kMotionNumbers);
  write_motion({.world_T_imu = {.R = so3::exp(0.2 * random.normal_vector(3)),
                                .p = 0.3 * random.normal_vector(3)},
                .v_world = random.normal_vector(3)},
               x.data());
  return x;
}

// The blocks of a term, the calibration's last. The intrinsics may have as many numbers as a pose.
Blocks blocks_with(std::vector<std::vector<double>> numbers, const Calibration& calibration) {
  for (auto& block : numbers_of(calibration)) numbers.push_back(std::move(block));
  Blocks blocks{&kStandardChart, std::move(numbers)};
  if (!calibration.intrinsics.empty()) blocks.plain_from = blocks.numbers.size() - 1;
  return blocks;
}

TEST(CalibratedCosts, HaveTheirDerivatives) {
  Random random(1);
  for (const Distortion distortion :
       {Distortion::kNone, Distortion::kRadtan, Distortion::kEquidistant}) {
    for (const double readout : {0.0, 0.02}) {
      for (const Parts& parts :
           {Parts{}, Parts{.extrinsics = false}, Parts{.time_offset = false},
            Parts{.extrinsics = false, .time_offset = false, .lens = false},
            Parts{.extrinsics = false, .lens = false, .readout = false}, Parts{.readout = false}}) {
        const Camera camera = rolling_camera(distortion, readout);
        const Calibration calibration = calibration_with(camera, parts);
        const CalibratedTerm term{.camera = {camera, 0, calibration, 0.001},
                                  .motion = some_readout(random),
                                  .of_anchor = camera.cam_T_imu,
                                  .pixel = {300, 200},
                                  .sigma = 0.7};
        const std::vector<double> point = {6, random.normal(), random.normal()};
        const std::vector<double> inverse_depth = {0.1 * random.normal(), 0.1 * random.normal(),
                                                   random.uniform(0.05, 0.2)};
        const std::vector<double> view = motion_near(random), from = motion_near(random);
        expect_numeric(CalibratedCost(term, ViewForm::kPoint),
                       blocks_with({view, point}, calibration), 1e-5);
        expect_numeric(CalibratedCost(term, ViewForm::kAnchored),
                       blocks_with({view, from, inverse_depth}, calibration), 1e-5);
        expect_numeric(CalibratedCost(term, ViewForm::kAnchor),
                       blocks_with({inverse_depth}, calibration), 1e-5);
      }
    }
  }
}

// The axes of the landmark move with the extrinsics of the view's camera, or with another's.
TEST(CalibratedCosts, HaveTheirDerivativesByTheCameraOfTheAnchor) {
  Random random(6);
  const Camera camera = rolling_camera(Distortion::kRadtan, 0.02);
  const Calibration calibration = calibration_with(camera, {});
  for (const AnchorFace face : {AnchorFace::kFront, AnchorFace::kRight}) {
    for (const bool is_view : {true, false}) {
      const AnchorCamera anchor{
          .face = face, .imu_T_line = some_readout(random).after(0.01), .is_view = is_view};
      const CalibratedTerm term{.camera = {camera, 0, calibration, 0.001},
                                .motion = some_readout(random),
                                .anchor = anchor,
                                .pixel = {300, 200}};
      const SE3 axes = anchor.axes_T_imu(camera.cam_T_imu.inverse());
      const Eigen::Vector3d q = axes * Eigen::Vector3d(6, 0.3, -0.4);
      const std::vector<double> inverse_depth = {q.x() / q.z(), q.y() / q.z(), 1 / q.z()};
      const std::vector<double> view = motion_near(random), from = motion_near(random);
      for (const bool own : {true, false}) {
        Blocks blocks = own ? blocks_with({inverse_depth}, calibration)
                            : blocks_with({view, from, inverse_depth}, calibration);
        const CalibratedCost cost(term, own ? ViewForm::kAnchor : ViewForm::kAnchored);
        if (!is_view) {
          // Behind the intrinsics, which are no motion, a pose that is one: its own last block.
          EXPECT_EQ(cost.parameter_block_sizes().back(), kPoseNumbers);
          blocks.numbers.emplace_back(kPoseNumbers);
          write_pose(camera.cam_T_imu.inverse(), blocks.numbers.back().data());
          blocks.plain_until = blocks.numbers.size() - 1;
        }
        expect_numeric(cost, blocks, 1e-5);
      }
    }
  }
}

TEST(CalibratedCosts, WithTheKnownCalibrationAreThoseOfAKnownOne) {
  Random random(2);
  const Camera camera = rolling_camera(Distortion::kRadtan, 0.02);
  const Calibration calibration = calibration_with(camera, {});
  const ReadoutMotion motion = some_readout(random);
  const Eigen::Vector2d pixel(250, 320);
  const PixelTerm known{.camera = &camera,
                        .cam_T_imu = at_line(camera, motion, pixel).cam_T_imu,
                        .of_anchor = camera.cam_T_imu,
                        .pixel = pixel};
  const CalibratedTerm term{.camera = {camera, 0, calibration, *calibration.time_offset},
                            .motion = motion,
                            .of_anchor = camera.cam_T_imu,
                            .pixel = pixel};
  const std::vector<double> view = motion_near(random), from = motion_near(random);
  const std::vector<double> point = {6, 0.4, -0.3}, inverse_depth = {0.1, -0.05, 0.15};
  EXPECT_TRUE(agree(
      residual(CalibratedCost(term, ViewForm::kPoint), blocks_with({view, point}, calibration)),
      residual(PointCost(known), {&kStandardChart, {view, point}}), 1e-9));
  EXPECT_TRUE(agree(residual(CalibratedCost(term, ViewForm::kAnchored),
                             blocks_with({view, from, inverse_depth}, calibration)),
                    residual(AnchoredCost(known), {&kStandardChart, {view, from, inverse_depth}}),
                    1e-9));
  EXPECT_TRUE(agree(
      residual(CalibratedCost(term, ViewForm::kAnchor), blocks_with({inverse_depth}, calibration)),
      residual(AnchorCost(known), {&kStandardChart, {inverse_depth}}), 1e-9));
}

// A larger offset: the image was taken later, where the motion has led in the meantime.
TEST(CalibratedCosts, AnImageIsTakenLaterByTheOffset) {
  Random random(3);
  const Camera camera = rolling_camera(Distortion::kNone, 0);
  Calibration calibration = calibration_with(camera, {});
  calibration.time_offset = 0.009;
  const ReadoutMotion motion = some_readout(random);
  const CalibratedTerm term{
      .camera = {camera, 0, calibration, 0.002}, .motion = motion, .pixel = {310, 190}};
  std::vector<double> view = motion_near(random);
  const std::vector<double> point = {6, 0.4, -0.3};
  const Eigen::VectorXd later =
      residual(CalibratedCost(term, ViewForm::kPoint), blocks_with({view, point}, calibration));
  write_pose(read_pose(view.data()) * motion.after(0.007), view.data());
  const PixelTerm known{.camera = &camera, .cam_T_imu = camera.cam_T_imu, .pixel = term.pixel};
  EXPECT_TRUE(agree(later, residual(PointCost(known), {&kStandardChart, {view, point}}), 1e-9));
}

TEST(CalibratedCosts, APointBehindTheCameraCountsAndDoesNotPull) {
  const Camera camera = rolling_camera(Distortion::kNone, 0);
  const Calibration calibration = calibration_with(camera, {});
  const CalibratedTerm term{.camera = {camera, 0, calibration, 0}, .pixel = {300, 200}};
  Random random(4);
  const Blocks behind = blocks_with({motion_near(random), {-5, 0, 0}}, calibration);
  const CalibratedCost cost(term, ViewForm::kPoint);
  EXPECT_EQ(residual(cost, behind), Eigen::Vector2d(kNotSeen, kNotSeen));
  for (const Eigen::MatrixXd& J : test::jacobians(cost, behind)) EXPECT_TRUE(J.isZero(0));
}

TEST(CalibratedCosts, ThePriorHasItsDerivatives) {
  Random random(5);
  const Camera camera = rolling_camera(Distortion::kEquidistant, 0.02);
  const Calibration mean = calibration_with(camera, {});
  Calibration at = mean;
  at.imu_T_camera[0] = {.R = so3::exp(0.3 * random.normal_vector(3)) * mean.imu_T_camera[0].R,
                        .p = mean.imu_T_camera[0].p + 0.1 * random.normal_vector(3)};
  at.time_offset = 0.02;
  at.intrinsics[0].projection += random.normal_vector(4);
  const int n = CalibrationBlocks(mean).errors();
  EXPECT_EQ(n, 6 + 1 + 12);
  const Eigen::MatrixXd W = test::random_covariance(random, n, 0.5)
                                .llt()
                                .matrixL()
                                .solve(Eigen::MatrixXd::Identity(n, n));
  const CalibrationCost cost(mean, W);
  expect_numeric(cost, blocks_with({}, at), 1e-6);
  EXPECT_TRUE(
      agree(residual(cost, blocks_with({}, at)), W * calibration_difference(at, mean), 1e-12));
  EXPECT_TRUE(residual(cost, blocks_with({}, mean)).isZero(1e-12));
}

ImuCorrection some_imu(Random& random, bool g_sensitivity) {
  ImuCorrection imu{.has_g_sensitivity = g_sensitivity};
  imu.set(0.05 * random.normal_vector(imu.size()));
  return imu;
}

std::vector<double> numbers_of(const ImuCorrection& imu) {
  const auto parameters = imu.parameters();
  return {parameters.begin(), parameters.end()};
}

std::vector<double> biases_near(Random& random) {
  const Eigen::VectorXd biases = 0.1 * random.normal_vector(6);
  return {biases.begin(), biases.end()};
}

ImuLink some_link(Random& random) {
  std::vector<ImuInterval> intervals;
  for (int i = 0; i < 8; ++i) {
    intervals.push_back({.tau = 0.01,
                         .specific_force_imu = Eigen::Vector3d(0, 0, 9.8) + random.normal_vector(3),
                         .angular_rate_imu = random.normal_vector(3)});
  }
  return imu_link(intervals, Vector6d::Zero(),
                  {.accelerometer_noise_density = 0.5,
                   .accelerometer_random_walk = 0.5,
                   .gyroscope_noise_density = 0.5,
                   .gyroscope_random_walk = 0.5});
}

TEST(CalibratedCosts, OfLinksAndStartsHaveTheirDerivativesByTheImu) {
  Random random(7);
  for (const bool g_sensitivity : {true, false}) {  // 24 parameters, or as many as a motion has
    const ImuCorrection imu = some_imu(random, g_sensitivity);
    BatchGraph graph;
    graph.calibration.emplace().imu = imu;
    graph.start_whitening =
        test::random_covariance(random, 15, 0.5).llt().matrixL().solve(Matrix15d::Identity());
    graph.start_by_imu = Eigen::MatrixXd::NullaryExpr(
        15, imu.size(), [&random](Eigen::Index, Eigen::Index) { return random.normal(); });
    graph.imu_of_start = 0.01 * random.normal_vector(imu.size());
    const Blocks start{
        &kStandardChart, {motion_near(random), biases_near(random), numbers_of(imu)}, 2};
    const auto of_start = start_cost(graph);
    ASSERT_EQ(of_start->parameter_block_sizes().size(), 3U);
    expect_numeric(*of_start, start, 1e-6);

    const ImuLink link = some_link(random);
    const Blocks blocks{&kStandardChart,
                        {motion_near(random), biases_near(random), motion_near(random),
                         biases_near(random), numbers_of(imu)},
                        4};
    const auto of_link = link_cost(graph, link);
    ASSERT_EQ(of_link->parameter_block_sizes().size(), 5U);
    expect_numeric(*of_link, blocks, 1e-5);
    EXPECT_TRUE(
        agree(residual(*of_link, blocks),
              residual(LinkCost(corrected(imu, link), graph.gravity),
                       {&kStandardChart, {blocks.numbers.begin(), blocks.numbers.end() - 1}}),
              1e-12));
  }
}

TEST(CalibratedCosts, OfAKnownImuAreThoseOfItsSamples) {
  Random random(8);
  BatchGraph graph;
  const ImuLink link = some_link(random);
  EXPECT_EQ(start_cost(graph)->parameter_block_sizes().size(), 2U);
  EXPECT_EQ(link_cost(graph, link)->parameter_block_sizes().size(), 4U);
  graph.calibration.emplace().time_offset = 0.01;
  EXPECT_EQ(link_cost(graph, link)->parameter_block_sizes().size(), 4U);
  // A start that does not depend on the parameters that are estimated.
  graph.calibration->imu.emplace();
  EXPECT_EQ(start_cost(graph)->parameter_block_sizes().size(), 2U);
  EXPECT_EQ(link_cost(graph, link)->parameter_block_sizes().size(), 5U);
}

}  // namespace
}  // namespace chasles
