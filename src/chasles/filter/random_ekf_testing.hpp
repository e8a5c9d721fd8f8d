#pragma once

#include <vector>

#include <chasles/filter/ekf.hpp>
#include <chasles/filter/inertial_testing.hpp>
#include <chasles/filter/testing.hpp>

// Filters and measurements at random.
namespace chasles::test {

inline Eigen::MatrixXd random_matrix(Random& random, Eigen::Index rows, Eigen::Index cols) {
  Eigen::MatrixXd M(rows, cols);
  for (auto column : M.colwise()) column = random.normal_vector(rows);
  return M;
}

/// A filter with a velocity, six additive states and landmarks that are correlated with the core.
inline Ekf some_filter(const ErrorChart& chart, Random& random, int landmarks) {
  const State x = random_state(random, {true, 6, 0, 0});
  Ekf ekf(chart, x, random_covariance(random, 15, 0.1), {});
  std::vector<NewLandmark> fresh;
  for (int i = 0; i < landmarks; ++i) {
    fresh.push_back({.id = 100 + i,
                     .p_world = 20 * random.normal_vector(3),
                     .d_pose = random_matrix(random, 3, 6),
                     .noise = random_covariance(random, 3, 0.2)});
  }
  ekf.add(fresh);
  return ekf;
}

inline Measurement some_measurement(Random& random, int landmark, Eigen::Index rows) {
  Measurement z;
  z.landmark = landmark;
  z.residual = 0.2 * random.normal_vector(rows);
  z.d_core = random_matrix(random, rows, 6);
  z.d_landmark = random_matrix(random, rows, 3);
  z.noise = random_covariance(random, static_cast<int>(rows), 0.3);
  return z;
}

inline Measurement some_core_measurement(Random& random, int column, Eigen::Index width) {
  Measurement z = some_measurement(random, -1, 4);
  z.core_column = column;
  z.d_core = random_matrix(random, 4, width);
  z.d_landmark.resize(0, 3);
  return z;
}

inline Eigen::MatrixXd innovation(const Ekf& ekf, const DenseMeasurement& all) {
  return all.H * ekf.covariance() * all.H.transpose() + all.R;
}

inline std::vector<Measurement> some_measurements(Random& random) {
  return {some_measurement(random, 0, 3),       some_measurement(random, 2, 2),
          some_core_measurement(random, 9, 6),  some_measurement(random, 1, 4),
          some_core_measurement(random, 3, 12), some_measurement(random, 2, 3)};
}

/// More rows than are applied together.
inline std::vector<Measurement> many_measurements(Random& random, int landmarks) {
  std::vector<Measurement> result{some_core_measurement(random, 9, 6)};
  for (int i = 0; i < 90; ++i) {
    result.push_back(some_measurement(random, i % landmarks, 1 + i % 5));
    result.back().noise *= 100;
  }
  return result;
}

}  // namespace chasles::test
