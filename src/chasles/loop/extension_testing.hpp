#pragma once

#include <string>
#include <vector>

#include <Eigen/Cholesky>

#include <chasles/loop/map_testing.hpp>

/// Maps that runs leave that began in another one. Included by tests only.
namespace chasles::test {

inline Eigen::VectorXd positions(const LandmarkMap& map) {
  Eigen::VectorXd all(3 * static_cast<Eigen::Index>(map.points.size()));
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    all.segment<3>(3 * static_cast<Eigen::Index>(i)) = map.points[i].p_map;
  }
  return all;
}

/// A map, and for each of its points the true one.
struct MapOfTruth {
  LandmarkMap map;
  std::vector<int> indices;
};

/// A run in `base` that measures all points of the corridor between two x, with errors that drift:
/// the Kalman filter, in information form, of the map and of what the run measures. In the frame of
/// the corridor. Given the same random numbers, two runs measure the same.
inline MapOfTruth extended_map(const MapOfTruth& base, const LandmarkMap& corridor, double from,
                               double to, int number, Random& random) {
  using Eigen::Index;
  using Eigen::MatrixXd;
  using Eigen::VectorXd;
  MapOfTruth run = base;
  run.map.sessions.push_back({.name = "run-" + std::to_string(number),
                              .begin = Time(100 * number),
                              .end = Time(100 * number + 5),
                              .cameras = {}});
  std::vector<int> measured;
  for (std::size_t i = 0; i < corridor.points.size(); ++i) {
    const MapPoint& truth = corridor.points[i];
    if (truth.p_map.x() < from || truth.p_map.x() > to) continue;
    const auto known = std::ranges::find(run.indices, static_cast<int>(i));
    measured.push_back(static_cast<int>(known - run.indices.begin()));
    if (known != run.indices.end()) continue;
    run.indices.push_back(static_cast<int>(i));
    MapPoint fresh = truth;
    fresh.session = static_cast<int>(run.map.sessions.size()) - 1;
    fresh.appearance = {};
    fresh.appearance.add(seen_again(random, truth.appearance.views().front(), 10));
    run.map.points.push_back(fresh);
  }
  const auto n = 3 * static_cast<Index>(run.indices.size()),
             n_0 = 3 * static_cast<Index>(base.indices.size()),
             m = 3 * static_cast<Index>(measured.size());
  MatrixXd H = MatrixXd::Zero(m, n), R(m, m), U(m, corridor.covariance.rank());
  VectorXd z(m);
  const VectorXd y = random.normal_vector(corridor.covariance.rank());
  for (std::size_t k = 0; k < measured.size(); ++k) {
    const auto row = 3 * static_cast<Index>(k);
    const int truth = run.indices[static_cast<std::size_t>(measured[k])];
    H.block<3, 3>(row, 3 * measured[k]).setIdentity();
    U.middleRows<3>(row) = 0.5 * corridor.covariance.shared().middleRows<3>(3 * truth);
    z.segment<3>(row) = corridor.points[static_cast<std::size_t>(truth)].p_map +
                        U.middleRows<3>(row) * y + 0.02 * random.normal_vector(3);
  }
  R = U * U.transpose() + 4e-4 * MatrixXd::Identity(m, m);
  const MatrixXd HtRi = R.llt().solve(H).transpose();
  MatrixXd information = HtRi * H;
  VectorXd right = HtRi * z;
  const MatrixXd of_base =
      whole_covariance(base.map.covariance).llt().solve(MatrixXd::Identity(n_0, n_0));
  information.topLeftCorner(n_0, n_0) += of_base;
  right.head(n_0) += of_base * positions(base.map);
  const Eigen::LLT<MatrixXd> llt(information);
  const VectorXd mean = llt.solve(right);
  for (std::size_t i = 0; i < run.map.points.size(); ++i) {
    run.map.points[i].p_map = mean.segment<3>(3 * static_cast<Index>(i));
    run.map.points[i].observations += 5;
  }
  run.map.covariance =
      JointCovariance::of_matrix(llt.solve(MatrixXd::Identity(n, n)), {.error = 0, .rank = 40});
  return run;
}

}  // namespace chasles::test
