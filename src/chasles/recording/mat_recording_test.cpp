#include <matio.h>

#include <chasles/recording/readers.hpp>
#include <chasles/recording/testing.hpp>

namespace chasles {
namespace {

using test::Drive;
using test::drive;
using test::expect_parts;
using test::input_error;

/// A variable, first index fastest, as in MATLAB.
struct Matrix {
  std::vector<std::size_t> shape;
  std::vector<double> values;
};
using Variables = std::map<std::string, Matrix>;

void write_mat(const std::filesystem::path& file, const Variables& variables,
               matio_compression compression = MAT_COMPRESSION_ZLIB) {
  mat_t* mat = Mat_CreateVer(file.c_str(), nullptr, MAT_FT_MAT5);
  ASSERT_NE(mat, nullptr);
  for (auto [name, matrix] : variables) {
    matvar_t* variable = Mat_VarCreate(name.c_str(), MAT_C_DOUBLE, MAT_T_DOUBLE,
                                       static_cast<int>(matrix.shape.size()), matrix.shape.data(),
                                       matrix.values.data(), 0);
    ASSERT_EQ(Mat_VarWrite(mat, variable, compression), 0);
    Mat_VarFree(variable);
  }
  Mat_Close(mat);
}

/// A STARS file of a recording.
Variables variables_of(const Recording& r, std::size_t tracks) {
  const std::size_t T = r.frames.size();
  Variables v;
  v["fu"] = {{1, 1}, {r.rig.fx}};
  v["fv"] = {{1, 1}, {r.rig.fy}};
  v["cu"] = {{1, 1}, {r.rig.cx}};
  v["cv"] = {{1, 1}, {r.rig.cy}};
  v["b"] = {{1, 1}, {r.rig.baseline}};
  v["C_c_v"] = {{3, 3}, {0, 0, 1, -1, 0, 0, 0, -1, 0}};
  v["rho_v_c_v"] = {{3, 1}, {test::kRho[0], test::kRho[1], test::kRho[2]}};
  v["t"].shape = {1, T};
  for (const char* name : {"v_vk_vk_i", "w_vk_vk_i", "r_i_vk_i", "theta_vk_i"}) {
    v[name].shape = {3, T};
  }
  v["y_k_j"] = {{4, T, tracks}, std::vector<double>(4 * T * tracks, -1)};
  const auto append = [&](const std::string& name, const Eigen::Vector3d& column) {
    v[name].values.insert(v[name].values.end(), column.begin(), column.end());
  };
  for (std::size_t k = 0; k < T; ++k) {
    v["t"].values.push_back(to_seconds(r.frames[k].time));
    append("v_vk_vk_i", r.velocities[k].linear_imu);
    append("w_vk_vk_i", r.velocities[k].angular_imu);
    append("r_i_vk_i", r.truth[k].pose.p);
    append("theta_vk_i", so3::log(r.truth[k].pose.R));
    for (const StereoObservation& o : r.frames[k].observations) {
      const std::size_t at = 4 * (k + T * static_cast<std::size_t>(o.landmark));
      std::copy(o.pixels.begin(), o.pixels.end(), v["y_k_j"].values.begin() + at);
    }
  }
  for (const TrueLandmark& landmark : r.true_landmarks) append("rho_i_pj_i", landmark.p_world);
  v["rho_i_pj_i"].shape = {3, tracks};
  return v;
}

class MatRecording : public ::testing::Test {
 protected:
  Recording read() {
    const auto file = test::scratch() / "drive.mat";
    write_mat(file, variables);
    return read_mat_recording(file);
  }
  std::string error() {
    return input_error([this] { read(); });
  }

  static constexpr std::size_t kTracks = 40;
  Recording truth = drive(Drive{.frames = 20, .tracks = kTracks});
  Variables variables = variables_of(truth, kTracks);
};

TEST_F(MatRecording, HoldsWhatWasWritten) {
  const Recording r = read();
  EXPECT_EQ(r.name, "drive");
  EXPECT_EQ(r.rig.fx, truth.rig.fx);
  EXPECT_EQ(r.rig.fy, truth.rig.fy);
  EXPECT_EQ(r.rig.cx, truth.rig.cx);
  EXPECT_EQ(r.rig.cy, truth.rig.cy);
  EXPECT_EQ(r.rig.baseline, truth.rig.baseline);
  ASSERT_EQ(r.velocities.size(), 20u);
  EXPECT_EQ(r.velocities[7].linear_imu, truth.velocities[7].linear_imu);
  EXPECT_EQ(r.velocities[7].angular_imu, truth.velocities[7].angular_imu);
  EXPECT_EQ(r.velocities[7].time, truth.velocities[7].time);
  ASSERT_EQ(r.frames.size(), 20u);
  ASSERT_EQ(r.frames[7].observations.size(), truth.frames[7].observations.size());
  EXPECT_EQ(r.frames[7].observations[2].landmark, truth.frames[7].observations[2].landmark);
  EXPECT_EQ(r.frames[7].observations[2].pixels, truth.frames[7].observations[2].pixels);
  EXPECT_EQ(r.true_landmarks[5].p_world, truth.true_landmarks[5].p_world);
}

// Truth, extrinsics and pixels are consistent: the landmarks of the file, projected from its poses,
// agree with its pixels.
TEST_F(MatRecording, TheTrueLandmarksProjectOntoTheObservations) {
  const Recording r = read();
  for (std::size_t k = 0; k < r.frames.size(); ++k) {
    for (const StereoObservation& o : r.frames[k].observations) {
      const auto& landmark = r.true_landmarks[static_cast<std::size_t>(o.landmark)].p_world;
      const auto seen = project(r.rig, r.rig.cam0_T_imu * (r.truth[k].pose.inverse() * landmark));
      ASSERT_TRUE(seen.has_value());
      EXPECT_LT((seen->pixels - o.pixels).norm(), 1e-9);
    }
  }
}

TEST_F(MatRecording, WhatLastsLongerThanTheTracksIsLeftOut) {
  for (const char* name : {"v_vk_vk_i", "w_vk_vk_i", "r_i_vk_i", "theta_vk_i"}) {
    variables[name].shape[1] += 2;
    variables[name].values.resize(variables[name].values.size() + 6);
  }
  Recording r = read();
  EXPECT_EQ(r.velocities.size(), 20u);
  EXPECT_EQ(r.truth.size(), 20u);
  EXPECT_TRUE(r.remarks.empty());
  variables["t"].shape[1] = 21;
  variables["t"].values.push_back(2);
  r = read();
  EXPECT_EQ(r.frames.size(), 20u);
  expect_parts(r.remarks.at(0), {"21 time stamps and 20 frames: the first 20 are used"});
}

TEST_F(MatRecording, TruthIsOptional) {
  for (const char* name : {"r_i_vk_i", "theta_vk_i", "rho_i_pj_i"}) variables.erase(name);
  const Recording r = read();
  EXPECT_TRUE(r.truth.empty());
  EXPECT_TRUE(r.true_landmarks.empty());
}

TEST_F(MatRecording, StatedVariancesBecomeStandardDeviations) {
  EXPECT_FALSE(read().velocity_sigma);
  EXPECT_FALSE(read().pixel_sigma);
  variables["v_var"] = {{3, 1}, {0.01, 0.04, 0.09}};
  variables["w_var"] = {{3, 1}, {1, 4, 9}};
  variables["y_var"] = {{4, 1}, {0.25, 1, 4, 16}};
  const Recording r = read();
  EXPECT_LT((r.velocity_sigma->linear - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-15);
  EXPECT_EQ(r.velocity_sigma->angular, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(*r.pixel_sigma, Eigen::Vector4d(0.5, 1, 2, 4));
}

TEST_F(MatRecording, AVarianceThatIsNotPositiveIsRejected) {
  variables["y_var"] = {{4, 1}, {0.25, 0, 4, 16}};
  expect_parts(error(), {"y_var", "positive"});
}

TEST_F(MatRecording, MissingFieldsAndWrongShapesAreNamed) {
  variables["rho_c_v"] = variables["rho_v_c_v"];
  variables.erase("rho_v_c_v");
  expect_parts(error(), {"drive.mat: field 'rho_v_c_v': is missing", "did you mean 'rho_c_v'?"});
  variables = variables_of(truth, kTracks);
  variables["w_vk_vk_i"] = {{3, 19}, std::vector<double>(57)};
  expect_parts(error(), {"field 'w_vk_vk_i': has shape (3, 19), expected (3, at least 20)"});
  variables = variables_of(truth, kTracks);
  variables["y_k_j"].shape = {2, 40, kTracks};
  expect_parts(error(), {"field 'y_k_j': has shape (2, 40, 40), expected (4, K, M)"});
}

TEST_F(MatRecording, NumbersThatAreNotFiniteAreNamedWithTheirIndex) {
  variables["v_vk_vk_i"].values[3 * 4 + 1] = NAN;
  expect_parts(error(), {"field 'v_vk_vk_i': value nan at index [1, 4]"});
  variables = variables_of(truth, kTracks);
  variables["y_k_j"].values[4 * (6 + 20 * 3) + 2] = INFINITY;
  expect_parts(error(), {"field 'y_k_j': value inf at index [2, 6, 3]"});
}

TEST_F(MatRecording, ImpossibleValuesAreRejected) {
  variables["t"].values[5] = variables["t"].values[4];
  expect_parts(error(), {"field 't': index [0, 5]", "rise strictly"});
  variables = variables_of(truth, kTracks);
  variables["b"].values[0] = -0.5;
  expect_parts(error(), {"field 'b': is -0.5, expected a positive number"});
  variables = variables_of(truth, kTracks);
  variables["C_c_v"].values = {0, 0, 1, 1, 0, 0, 0, -1, 0};
  expect_parts(error(), {"field 'C_c_v'", "reflection"});
}

TEST(MatFile, AMissingFileAndAForeignOneAreRejected) {
  const auto folder = test::scratch();
  expect_parts(input_error([&] { read_mat_recording(folder / "none.mat"); }),
               {"none.mat: no such file"});
  test::spill(folder / "text.mat", "no matrices here");
  expect_parts(input_error([&] { read_mat_recording(folder / "text.mat"); }), {"text.mat"});
}

TEST(MatFile, TextIsNoNumber) {
  const auto folder = test::scratch();
  mat_t* mat = Mat_CreateVer((folder / "text.mat").c_str(), nullptr, MAT_FT_MAT5);
  std::size_t shape[2] = {1, 3};
  char text[] = "abc";
  matvar_t* variable = Mat_VarCreate("t", MAT_C_CHAR, MAT_T_UINT8, 2, shape, text, 0);
  Mat_VarWrite(mat, variable, MAT_COMPRESSION_NONE);
  Mat_VarFree(variable);
  Mat_Close(mat);
  expect_parts(input_error([&] { read_mat_recording(folder / "text.mat"); }),
               {"field 't': is not a numeric array"});
}

// libmatio would allocate gigabytes for these.
TEST(MatFile, AnArrayWhoseHeaderIsNoneIsRejected) {
  const auto folder = test::scratch();
  write_mat(folder / "whole.mat", variables_of(drive(Drive{.frames = 8, .tracks = 10}), 10),
            MAT_COMPRESSION_NONE);
  const std::string whole = test::slurp(folder / "whole.mat");
  const std::size_t dimensions = whole.find(std::string("\x05\0\0\0\x08\0\0\0", 8));
  ASSERT_NE(dimensions, std::string::npos);
  std::string other = whole;
  test::spill(folder / "other.mat", other.replace(7, 3, "7.3"));
  expect_parts(input_error([&] { read_mat_recording(folder / "other.mat"); }),
               {"other.mat: cannot be opened as a MATLAB .mat file"});
  for (const std::size_t byte : {3u, 4u, 5u, 7u}) {
    std::string damaged = whole;
    damaged[dimensions + byte] = '\x03';
    test::spill(folder / "damaged.mat", damaged);
    expect_parts(input_error([&] { read_mat_recording(folder / "damaged.mat"); }),
                 {"damaged.mat", "the header of the array at byte 128 is not one"});
  }
}

// Any truncation gives an InputError, never a crash.
// Numbers of one byte, which compress well, take eight as doubles.
TEST(MatFile, AnArrayThatTakesMoreThanTheBudgetIsRejected) {
  const auto file = test::scratch() / "a.mat";
  mat_t* mat = Mat_CreateVer(file.c_str(), nullptr, MAT_FT_MAT5);
  std::size_t shape[] = {1, 100'000};
  std::vector<std::int8_t> zeros(100'000);
  matvar_t* variable = Mat_VarCreate("t", MAT_C_INT8, MAT_T_INT8, 2, shape, zeros.data(), 0);
  ASSERT_EQ(Mat_VarWrite(mat, variable, MAT_COMPRESSION_ZLIB), 0);
  Mat_VarFree(variable);
  Mat_Close(mat);
  ::setenv("CHASLES_READ_MEMORY", "500K", 1);
  const std::string message = input_error([&] { read_mat_recording(file); });
  ::unsetenv("CHASLES_READ_MEMORY");
  expect_parts(message, {"a.mat: field 't': has 100000 numbers", "CHASLES_READ_MEMORY"});
}

TEST(MatFile, NoTruncationCrashes) {
  const auto folder = test::scratch();
  for (const auto compression : {MAT_COMPRESSION_NONE, MAT_COMPRESSION_ZLIB}) {
    write_mat(folder / "whole.mat", variables_of(drive(Drive{.frames = 8, .tracks = 10}), 10),
              compression);
    const std::string whole = test::slurp(folder / "whole.mat");
    for (std::size_t size = 0; size + 1 < whole.size(); size += 37) {
      test::spill(folder / "part.mat", whole.substr(0, size));
      EXPECT_THROW(read_mat_recording(folder / "part.mat"), InputError) << size << " bytes";
    }
  }
}

}  // namespace
}  // namespace chasles
