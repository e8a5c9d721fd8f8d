#include <csignal>
#include <memory>

#include <sys/resource.h>

#include <chasles/camera/camera_testing.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/testing.hpp>
#include <chasles/recording/write_euroc.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr int kWidth = 40, kHeight = 30;

// Two cameras; the second has no image at every third time.
class Stripes : public ImageSource {
 public:
  explicit Stripes(std::size_t count, int width = kWidth) : count_(count), width_(width) {}
  std::size_t size() const override { return count_; }
  Time time(std::size_t i) const override {
    return Time(1'403'636'584'763'555'584) + Time(50'000'000 * static_cast<std::int64_t>(i));
  }
  ImageFrame read(std::size_t i) const override {
    ImageFrame frame{.time = time(i), .images = {image(i), image(i + 100)}};
    if (i % 3 == 2) frame.images[1] = {};
    return frame;
  }
  GrayImage image(std::size_t seed) const {
    GrayImage image{.width = width_, .height = kHeight, .pixels = {}};
    for (int k = 0; k < width_ * kHeight; ++k) {
      image.pixels.push_back(
          static_cast<std::uint8_t>(static_cast<std::size_t>(k) * 7 + 31 * seed));
    }
    return image;
  }

 private:
  std::size_t count_;
  int width_;
};

Camera camera(Distortion distortion, double y) {
  return {.width = kWidth,
          .height = kHeight,
          .fx = 458.654,
          .fy = 457.296,
          .cx = 20.5 / 3,
          .cy = 15.1,
          .distortion = distortion,
          .coefficients = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05},
          .cam_T_imu = {so3::exp({0.1, -1.2, 0.7}), {0.01, y, -0.3}}};
}

Recording example_recording(std::size_t frames = 7) {
  Recording r;
  r.name = "example";
  const auto images = std::make_shared<Stripes>(frames);
  r.images = images;
  r.cameras = {camera(Distortion::kRadtan, 0.02), camera(Distortion::kEquidistant, 0.13)};
  r.cameras[0].coefficients = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, -0.1 / 3};
  r.imu_noise = ImuNoise{.accelerometer_noise_density = 2e-3,
                         .accelerometer_random_walk = 3e-3,
                         .gyroscope_noise_density = 1.7e-4,
                         .gyroscope_random_walk = 1.9e-5};
  for (int i = -5; i < 10 * static_cast<int>(frames) + 5; ++i) {
    r.imu.push_back({.time = images->time(0) + Time(5'000'000 * i),
                     .specific_force_imu = {9.8, 0.1 / (i + 20), i / 3.0},
                     .angular_rate_imu = {-1e-9 * i, 0.1, 2.0 / 3}});
  }
  for (std::size_t i = 0; i < frames; ++i) {
    const auto s = static_cast<double>(i);
    r.truth.push_back({images->time(i), {so3::exp({0.3 * s, -0.1, 0.2}), {s / 3, 1, -2}}});
    r.true_motion.push_back({.time = images->time(i),
                             .v_world = {1.0 / 3, s, 0},
                             .accelerometer_bias = {0.01, 0.02, 0.03 * s},
                             .gyroscope_bias = {-0.001, 0.002, 0}});
  }
  return r;
}

template <typename Call>
std::string usage_error(Call call) {
  try {
    call();
  } catch (const UsageError& error) {
    return error.what();
  }
  ADD_FAILURE() << "expected a UsageError, and there was none";
  return "";
}

TEST(WriteEuroc, APlanGoesAlongAndNeverStaysBehind) {
  const fs::path folder = test::scratch() / "rec";
  Recording r = example_recording(2);
  r.plan = {{.kind = PlanLine::Kind::kFurniture, .points = {{0, 0}, {1.0 / 3, 2}}}};
  write_euroc(r, folder);
  for (const fs::path& named : {folder, folder / "mav0"}) {
    const Plan plan = read_recording(named).plan;
    ASSERT_EQ(plan.size(), 1U) << named;
    EXPECT_EQ(plan[0].points, r.plan[0].points);
    EXPECT_EQ(plan[0].kind, PlanLine::Kind::kFurniture);
  }
  r.plan.clear();
  write_euroc(r, folder);
  EXPECT_TRUE(read_recording(folder).plan.empty());
}

TEST(WriteEuroc, ThatTheCalibrationIsExactIsReadOfAllCamerasOrOfNone) {
  const fs::path folder = test::scratch() / "rec";
  Recording r = example_recording();
  r.exact_calibration = true;
  write_euroc(r, folder);
  EXPECT_TRUE(read_recording(folder).exact_calibration);
  const fs::path file = folder / "mav0" / "cam1" / "sensor.yaml";
  std::string text = test::slurp(file);
  const std::string line = "calibration_is_exact: true";
  ASSERT_NE(text.find(line), std::string::npos);
  text.replace(text.find(line), line.size(), "calibration_is_exact: false");
  test::spill(file, text);
  EXPECT_FALSE(read_recording(folder).exact_calibration);
}

TEST(WriteEuroc, WhatIsWrittenIsReadAgain) {
  const fs::path folder = test::scratch() / "rec";
  const Recording r = example_recording();
  EXPECT_EQ(write_euroc(r, folder), 7U);
  const Recording back = read_recording(folder);
  ASSERT_EQ(back.imu.size(), r.imu.size());
  for (std::size_t i = 0; i < r.imu.size(); ++i) {
    EXPECT_EQ(back.imu[i].time, r.imu[i].time);
    EXPECT_EQ(back.imu[i].specific_force_imu, r.imu[i].specific_force_imu);
    EXPECT_EQ(back.imu[i].angular_rate_imu, r.imu[i].angular_rate_imu);
  }
  EXPECT_EQ(back.imu_noise->accelerometer_random_walk, 3e-3);
  EXPECT_EQ(back.imu_noise->gyroscope_noise_density, 1.7e-4);
  EXPECT_FALSE(back.imu_noise->exact);
  EXPECT_FALSE(back.exact_calibration);
  ASSERT_EQ(back.cameras.size(), 2U);
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_EQ(back.cameras[c].distortion, r.cameras[c].distortion);
    EXPECT_EQ(back.cameras[c].coefficients, r.cameras[c].coefficients);
    EXPECT_EQ(back.cameras[c].cx, r.cameras[c].cx);
    EXPECT_EQ(back.cameras[c].fy, r.cameras[c].fy);
    EXPECT_LT((back.cameras[c].cam_T_imu.R - r.cameras[c].cam_T_imu.R).norm(), 1e-14);
    EXPECT_LT((back.cameras[c].cam_T_imu.p - r.cameras[c].cam_T_imu.p).norm(), 1e-14);
  }
  ASSERT_EQ(back.truth.size(), r.truth.size());
  for (std::size_t i = 0; i < r.truth.size(); ++i) {
    EXPECT_EQ(back.truth[i].time, r.truth[i].time);
    EXPECT_LT((back.truth[i].pose.R - r.truth[i].pose.R).norm(), 1e-14);
    EXPECT_EQ(back.truth[i].pose.p, r.truth[i].pose.p);
    EXPECT_EQ(back.true_motion[i].v_world, r.true_motion[i].v_world);
    EXPECT_EQ(back.true_motion[i].accelerometer_bias, r.true_motion[i].accelerometer_bias);
    EXPECT_EQ(back.true_motion[i].gyroscope_bias, r.true_motion[i].gyroscope_bias);
  }
  ASSERT_EQ(back.images->size(), 7U);
  for (std::size_t i = 0; i < 7; ++i) {
    const ImageFrame frame = back.images->read(i), expected = r.images->read(i);
    EXPECT_EQ(frame.time, expected.time);
    ASSERT_EQ(frame.images.size(), 2U);
    EXPECT_EQ(frame.images[0].pixels, expected.images[0].pixels);
    EXPECT_EQ(frame.images[1].pixels, expected.images[1].pixels);
  }
}

TEST(WriteEuroc, EachLensIsReadAgain) {
  const fs::path folder = test::scratch();
  for (const test::Lens& lens : test::lenses()) {
    Recording r = example_recording(2);
    for (Camera& camera : r.cameras) {
      camera.distortion = lens.camera.distortion;
      camera.coefficients = lens.camera.coefficients;
    }
    write_euroc(r, folder);
    // EuRoC's format has no lens without distortion.
    const bool none = lens.camera.distortion == Distortion::kNone;
    const Camera back = read_recording(folder).cameras[1];
    EXPECT_EQ(back.distortion, none ? Distortion::kRadtan : lens.camera.distortion);
    const LensCoefficients zeros{0, 0, 0, 0};
    EXPECT_EQ(back.coefficients, none ? zeros : lens.camera.coefficients);
    EXPECT_EQ(back.fx, r.cameras[1].fx);
    EXPECT_EQ(back.cy, r.cameras[1].cy);
  }
}

TEST(WriteEuroc, HasTheLayoutOfTheRealRecordings) {
  const fs::path folder = test::scratch();
  write_euroc(example_recording(), folder);
  const std::string images = test::slurp(folder / "mav0/cam0/data.csv");
  EXPECT_TRUE(
      images.starts_with("#timestamp [ns],filename\n1403636584763555584,1403636584763555584.png\n"))
      << images;
  EXPECT_TRUE(fs::exists(folder / "mav0/cam1/data/1403636584763555584.png"));
  const std::string states = test::slurp(folder / "mav0/state_groundtruth_estimate0/data.csv");
  EXPECT_EQ(std::count(states.begin(),
                       states.begin() + static_cast<std::ptrdiff_t>(states.find('\n')), ','),
            16);
  test::expect_parts(test::slurp(folder / "mav0/cam1/sensor.yaml"),
                     {"sensor_type: camera", "T_BS:", "rate_hz: 20\n", "resolution: [40, 30]",
                      "camera_model: pinhole", "intrinsics: [458.654, 457.296, ",
                      "distortion_model: equidistant", "distortion_coefficients: [-0.28340811, "});
  test::expect_parts(test::slurp(folder / "mav0/imu0/sensor.yaml"),
                     {"sensor_type: imu", "rate_hz: 200\n", "gyroscope_noise_density: 0.00017"});
  const auto real = test::recordings();
  if (!real) GTEST_SKIP() << "no real recordings";
  const fs::path mh = *real / ".." / "euroc" / "MH_01_easy_17s" / "mav0";
  for (const char* table :
       {"cam0/data.csv", "imu0/data.csv", "state_groundtruth_estimate0/data.csv"}) {
    const auto first = [](const std::string& text) { return text.substr(0, text.find('\n')); };
    EXPECT_EQ(first(test::slurp(folder / "mav0" / table)), first(test::slurp(mh / table)));
  }
}

TEST(WriteEuroc, TheSameRecordingGivesTheSameBytes) {
  const fs::path folder = test::scratch();
  write_euroc(example_recording(), folder / "a");
  for (const int threads : {1, 2, 3, 16}) {
    write_euroc(example_recording(), folder / "b", {}, threads);
    std::size_t files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder / "a")) {
      if (!entry.is_regular_file()) continue;
      ++files;
      const fs::path other = folder / "b" / fs::relative(entry.path(), folder / "a");
      EXPECT_EQ(test::slurp(entry.path()), test::slurp(other)) << other << ", " << threads;
    }
    EXPECT_EQ(files, 1U + 2 + 2 + 2 * 2 + 7 + 5);
  }
}

// Whichever fails first, the error of the earliest frame is reported.
TEST(WriteEuroc, WhatFailsOnAnotherThreadIsSaid) {
  class Torn : public Stripes {
   public:
    using Stripes::Stripes;
    ImageFrame read(std::size_t i) const override {
      ImageFrame frame = Stripes::read(i);
      if (i == 3 || i == 5) frame.images.clear();
      return frame;
    }
  };
  Recording r = example_recording();
  r.images = std::make_shared<Torn>(7);
  for (const int threads : {1, 2, 16}) {
    const fs::path folder = test::scratch() / "rec";
    test::expect_parts(usage_error([&] { write_euroc(r, folder, {}, threads); }),
                       {"example", "at 1403636584913555584 ns do not fit the cameras"});
    EXPECT_FALSE(fs::exists(folder / "mav0/cam0/data.csv"));
  }
}

TEST(WriteEuroc, ATruthWithoutVelocitiesIsATrajectory) {
  const fs::path folder = test::scratch() / "rec";
  Recording r = example_recording();
  r.true_motion.clear();
  write_euroc(r, folder);
  EXPECT_FALSE(fs::exists(folder / "mav0/state_groundtruth_estimate0"));
  EXPECT_EQ(read_tum(folder / "truth.tum").size(), 7U);
  for (const char* inner : {"", "mav0"}) {
    const Recording again = read_recording(folder / inner);
    ASSERT_EQ(again.truth.size(), 7U) << inner;
    EXPECT_EQ(again.truth[3].time, r.truth[3].time);
    EXPECT_LT((again.truth[3].pose.p - r.truth[3].pose.p).norm(), 1e-9);
    EXPECT_TRUE(again.true_motion.empty());
  }
}

TEST(WriteEuroc, ATrajectoryBesideTheStatesComesFirst) {
  const fs::path folder = test::scratch() / "rec";
  const Recording r = example_recording();
  write_euroc(r, folder);
  write_tum({r.truth.begin(), r.truth.begin() + 2}, folder / "truth.tum");
  EXPECT_EQ(read_recording(folder).truth.size(), 2U);
}

TEST(WriteEuroc, ASecondWriteLeavesNothingOfTheFirst) {
  const fs::path folder = test::scratch() / "rec";
  write_euroc(example_recording(7), folder);
  write_euroc(example_recording(3), folder);
  EXPECT_EQ(read_recording(folder).images->size(), 3U);
  EXPECT_FALSE(fs::exists(folder / "mav0/cam0/data/1403636585063555584.png"));
}

TEST(WriteEuroc, EndsEarlyWhereItIsAskedTo) {
  const fs::path folder = test::scratch() / "rec";
  EXPECT_EQ(write_euroc(example_recording(), folder, [](std::size_t done) { return done < 4; }),
            4U);
  EXPECT_EQ(read_recording(folder).images->size(), 4U);
  // Files that are in progress are kept.
  EXPECT_EQ(write_euroc(
                example_recording(), folder, [](std::size_t) { return false; }, 3),
            3U);
  EXPECT_EQ(read_recording(folder).images->size(), 3U);
}

TEST(WriteEuroc, NeverReplacesWhatItDidNotWrite) {
  const fs::path folder = test::scratch();
  fs::create_directories(folder / "real" / "mav0");
  test::spill(folder / "real" / "mav0" / "body.yaml", "comment: Asctec Firefly MAV\n");
  fs::create_directories(folder / "other");
  test::spill(folder / "other" / "thesis.tex", "years of work");
  test::spill(folder / "file", "");
  for (const char* name : {"real", "other"}) {
    test::expect_parts(usage_error([&] { write_euroc(example_recording(), folder / name); }),
                       {name, "is not empty", "expected a new or empty folder"});
  }
  EXPECT_EQ(test::slurp(folder / "other" / "thesis.tex"), "years of work");
  EXPECT_TRUE(fs::exists(folder / "real" / "mav0" / "body.yaml"));
  test::expect_parts(usage_error([&] { write_euroc(example_recording(), folder / "file"); }),
                     {"file", "cannot be made"});
  test::expect_parts(usage_error([&] { write_euroc(example_recording(), "/proc/chasles"); }),
                     {"/proc/chasles", "cannot be made"});
}

TEST(WriteEuroc, AFullDiskIsAnError) {
  const fs::path folder = test::scratch() / "rec";
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{.rlim_cur = 512, .rlim_max = before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  std::string message;
  try {
    write_euroc(example_recording(), folder);
  } catch (const UsageError& error) {
    message = error.what();
  }
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  test::expect_parts(message, {"data.csv: cannot be written", "File too large"});
}

TEST(WriteEuroc, RejectsARecordingThatDoesNotFit) {
  const fs::path folder = test::scratch() / "rec";
  const auto rejected = [&](const Recording& r) {
    return usage_error([&] { write_euroc(r, folder); });
  };
  Recording r = example_recording();
  r.images = nullptr;
  test::expect_parts(rejected(r), {"has no images"});
  r = example_recording();
  r.cameras.clear();
  test::expect_parts(rejected(r), {"has no cameras"});
  r = example_recording();
  r.imu.clear();
  test::expect_parts(rejected(r), {"has no IMU samples"});
  r = example_recording();
  r.imu_noise.reset();
  test::expect_parts(rejected(r), {"has no noise densities"});
  EXPECT_FALSE(fs::exists(folder));
  r = example_recording();
  r.images = std::make_shared<Stripes>(3, kWidth + 1);
  test::expect_parts(rejected(r), {"the images at 1403636584763555584 ns do not fit the cameras"});
  r = example_recording();
  r.cameras.pop_back();
  test::expect_parts(rejected(r), {"do not fit the cameras; expected 1"});
}

}  // namespace
}  // namespace chasles
