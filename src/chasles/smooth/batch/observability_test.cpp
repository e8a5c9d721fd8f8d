#include <Eigen/LU>
#include <gtest/gtest.h>

#include <chasles/smooth/batch/observability.hpp>

namespace chasles {
namespace {

using Vector15d = Eigen::Matrix<double, 15, 1>;

Matrix15d prior() {
  Vector15d sigma;
  sigma << 0.01, 0.01, 1e-6, 1e-6, 1e-6, 1e-6, 0.05, 0.05, 0.05, 0.02, 0.02, 0.02, 0.005, 0.005,
      0.005;
  return sigma.cwiseAbs2().asDiagonal();
}

// Information on all but position and heading, which are unobservable.
Matrix15d informative() {
  Matrix15d data = Matrix15d::Zero();
  for (const int row : {0, 1, 6, 7, 8, 9, 10, 11, 12, 13, 14}) data(row, row) = 1e6;
  return data;
}

std::vector<std::string> directions(const Matrix15d& data) {
  return unobservable_directions((prior().inverse() + data).inverse(), prior());
}

TEST(Observability, WhatTheDataDetermineIsNotNamed) {
  EXPECT_TRUE(directions(informative()).empty());
}

TEST(Observability, ADirectionWithoutInformationIsNamedThoughThePriorKnowsIt) {
  Matrix15d data = informative();
  data(7, 7) = 0;
  EXPECT_EQ(directions(data), std::vector<std::string>{"velocity y"});
}

TEST(Observability, ACombinationIsNamedByItsParts) {
  Matrix15d data = informative();
  // Roll and accelerometer bias y have the same effect: only their difference is determined.
  Eigen::Matrix<double, 1, 15> difference = Eigen::Matrix<double, 1, 15>::Zero();
  difference[0] = 9.81;
  difference[10] = 1;
  data(0, 0) = data(10, 10) = 0;
  data += 1e4 * difference.transpose() * difference;
  ASSERT_EQ(directions(data).size(), 1u);
  EXPECT_EQ(directions(data).front(), "roll with accelerometer bias y");
}

TEST(Observability, NoDataShowNothing) { EXPECT_EQ(directions(Matrix15d::Zero()).size(), 11u); }

}  // namespace
}  // namespace chasles
