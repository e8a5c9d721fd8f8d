#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/eval/nees.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/report/testing.hpp>
#include <chasles/viewers/square.hpp>

namespace chasles {
namespace {

// An independent reader: the header by key, and the rows by their time as it is written.
struct Table {
  std::map<std::string, std::string> header;
  std::map<std::string, std::vector<double>> rows;
};

Table read_table(const std::string& text) {
  Table table;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string first, rest;
    words >> first;
    if (first.starts_with("#%")) {
      words >> table.header[first.substr(2)];
    } else if (!first.starts_with('#')) {
      for (double x = 0; words >> x;) table.rows[first].push_back(x);
    }
  }
  return table;
}

SE3 pose_of(const std::vector<double>& row) {
  const Eigen::Quaterniond q(row[6], row[3], row[4], row[5]);
  return {q.toRotationMatrix(), {row[0], row[1], row[2]}};
}

Matrix6d covariance_of(const std::vector<double>& row) {
  Matrix6d P;
  std::size_t at = 7;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) P(i, j) = P(j, i) = row.at(at++);
  }
  EXPECT_EQ(at, row.size());
  return P;
}

Run some_run(bool level) {
  Run run = test::synthetic_drive({.states = 60, .landmarks = 5}).run;
  // An inertial run's world is level.
  run.extra_names = {level ? "accelerometer_bias_x" : "velocity_x"};
  for (RunState& s : run.states) s.extra = s.extra_sigma = {0};
  run.states.front().pose_covariance.setZero();  // it defines the world
  for (std::size_t i = 1; i < run.states.size(); ++i) {
    Matrix6d A = Matrix6d::Identity();
    for (int k = 0; k < 36; ++k)
      A(k / 6, k % 6) += 0.4 * std::sin(7.0 * k + static_cast<double>(i));
    const double sigma = 0.02 + 0.001 * static_cast<double>(i);
    run.states[i].pose_covariance = sigma * sigma * A * A.transpose();
  }
  for (const RunState& s : run.states) {
    run.smoothed.push_back({.time = s.time,
                            .world_T_imu = s.world_T_imu,
                            .pose_covariance = 0.25 * s.pose_covariance});
  }
  return run;
}

// The error of the truth in the file against its pose, as SQUARE defines it.
double position_square(const std::vector<double>& row, const std::vector<double>& truth) {
  const SE3 estimate = pose_of(row);
  const Eigen::Vector3d e = estimate.R.transpose() * (pose_of(truth).p - estimate.p);
  return e.dot(covariance_of(row).topLeftCorner<3, 3>().inverse() * e);
}

TEST(SquareOfARun, ScoredWithoutAnAlignmentIsTheNeesOfTheRun) {
  for (const bool level : {false, true}) {
    const auto run = some_run(level);
    Trajectory estimate;
    std::vector<Matrix6d> covariances;
    for (const RunState& s : run.states) {
      estimate.push_back({.time = s.time, .pose = s.world_T_imu});
      covariances.push_back(s.pose_covariance);
    }
    const Nees expected =
        nees(associate(estimate, run.truth, run.pairing), covariances, PoseError::kStandard, level);
    const Table square = read_table(run_square(run, RunPath::kStates, "1.2.3"));
    const Table truth = read_table(square_truth(run, RunPath::kStates));
    ASSERT_EQ(square.rows.size(), run.states.size() - 1) << "but for the first pose";
    double sum = 0;
    for (const auto& [time, row] : square.rows) sum += position_square(row, truth.rows.at(time));
    const double mean = sum / static_cast<double>(square.rows.size());
    EXPECT_GT(mean, 0.01);
    EXPECT_NEAR(mean / expected.position_summary.mean, 1, 1e-9) << level;
    // The smoothed path here has half the sigmas.
    double smoothed = 0;
    for (const auto& [time, row] : read_table(run_square(run, RunPath::kSmoothed, "")).rows) {
      smoothed += position_square(row, truth.rows.at(time));
    }
    EXPECT_NEAR(smoothed / sum, 4, 1e-9);
  }
}

TEST(SquareOfARun, TheCovarianceIsOfAPerturbationInTheAxesOfTheImu) {
  const auto run = some_run(true);
  const Table square = read_table(run_square(run, RunPath::kStates, "1.2.3"));
  EXPECT_EQ(square.header.at("FORMAT"), "SQUARE/0.3");
  EXPECT_EQ(square.header.at("TANGENT_CONVENTION"), "right_perturbation");
  EXPECT_EQ(square.header.at("TANGENT_ORDER"), "translation_rotation");
  EXPECT_EQ(square.header.at("GAUGE"), "fixed");
  EXPECT_EQ(square.header.at("ALGORITHM_VERSION"), "1.2.3");
  const auto row = std::next(square.rows.begin(), 20)->second;
  const RunState& s = run.states[21];
  ASSERT_LT((pose_of(row).p - s.world_T_imu.p).norm(), 1e-12);
  ASSERT_LT((pose_of(row).R - s.world_T_imu.R).norm(), 1e-12);
  for (int axis = 0; axis < 6; ++axis) {
    // A small step along one axis of the file, and the standard error that it is.
    Vector6d xi = Vector6d::Zero();
    xi(axis) = 1e-5;
    const SE3 X{s.world_T_imu.R * so3::exp(xi.tail<3>()),
                s.world_T_imu.p + s.world_T_imu.R * xi.head<3>()};
    const double standard =
        normalised_square(pose_error(PoseError::kStandard, X, s.world_T_imu), s.pose_covariance);
    EXPECT_NEAR(xi.dot(covariance_of(row).inverse() * xi) / standard, 1, 1e-6) << axis;
  }
}

TEST(SquareOfARun, PosesWithoutACovarianceAreLeftOut) {
  auto run = some_run(true);
  run.states[7].pose_covariance(4, 4) = std::nan("");
  run.states[8].world_T_imu.p.x() = std::nan("");
  const std::string text = run_square(run, RunPath::kStates, "");
  EXPECT_EQ(read_table(text).rows.size(), run.states.size() - 3);
  EXPECT_EQ(text.find("nan"), std::string::npos);
  EXPECT_EQ(read_table(square_truth(run, RunPath::kStates)).rows.size(), run.states.size() - 1);
}

TEST(SquareOfARun, WhatTheRunDoesNotHaveIsNamed) {
  auto run = some_run(true);
  run.smoothed.clear();
  const auto message = [](const auto& of) -> std::string {
    try {
      of();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message([&] { run_square(run, RunPath::kSmoothed, ""); }).find("no smoothed.csv"),
            std::string::npos);
  run.truth.clear();
  EXPECT_NE(message([&] { square_truth(run, RunPath::kStates); }).find("no truth.tum"),
            std::string::npos);
  run.states.clear();
  EXPECT_NE(message([&] { run_square(run, RunPath::kStates, ""); }).find("no row in states.csv"),
            std::string::npos);
}

}  // namespace
}  // namespace chasles
