#pragma once

#include <map>
#include <memory>
#include <vector>

#include <Eigen/LU>

#include <chasles/filter/inertial_testing.hpp>
#include <chasles/loop/map_testing.hpp>
#include <chasles/loop/placed_map.hpp>

/// A run that continues a map. Included by tests only.
namespace chasles::test {

inline const Ekf::Options kRecalling{.map = Ekf::Map::kPast,
                                     .past = {.recalls = true, .records = true}};

/// A filter that has found its place in a map of six points, and beside it the textbook filter over
/// all errors: of the core, those that the points share and those of the place, the own errors of
/// the points, and the run's own landmarks 7, 8 and 9.
///
/// Points 1 and 3 of the map return into the state, then 1 and 7 leave it. No other point of the
/// map is observed.
struct RunInMap {
  static constexpr int kPoints = 6, kCore = 15;

  explicit RunInMap(std::uint64_t seed)
      : random(seed),
        map(std::make_shared<LandmarkMap>(corridor_map(seed, kPoints, 9, 4))),
        filter(started()),
        placed(map, filter.add_past(prior())) {
    append(Eigen::MatrixXd::Identity(shared_errors(), shared_errors()));
    for (const Eigen::Matrix3d& own : prior().own) append(own);
    for (int i = 0; i < 3; ++i) initialise(7 + i, {2.0 + 2 * i, 0.4, 1.5 - 0.5 * i});
    observe();
    walk();
    filter.revive(std::vector<int>{number_of(1), number_of(3)});
    observe();
    leave({0, 3});
    walk();
    observe();
  }

  /// The past landmark of a point of the map that has not returned.
  int number_of(int point) const { return placed.number() + 1 + point; }
  int shared_errors() const { return map->covariance.rank() + 4; }
  PriorMap prior() const {
    return chasles::placed(*map, std::vector{0, 1, 2, 3, 4, 5},
                           {.world_T_map = nav_T_map,
                            .pivot = {1, 2, 3},
                            .heading_sigma = 0.003,
                            .position_sigma = 0.05});
  }

  /// Derivative of the position in nav by all errors.
  Eigen::MatrixXd by_errors(LandmarkId id) const {
    Eigen::MatrixXd row = Eigen::MatrixXd::Zero(3, P.cols());
    if (id < kFirstMapId) {
      row.middleCols<3>(column_of_point(kPoints + static_cast<int>(id) - 7)).setIdentity();
      return row;
    }
    const auto point = static_cast<int>(id - kFirstMapId);
    row.middleCols(kCore, shared_errors()) = prior().shared.middleRows<3>(6 + 3 * point);
    row.middleCols<3>(column_of_point(point)).setIdentity();
    return row;
  }
  Eigen::MatrixXd frame_by_errors() const {
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(6, P.cols());
    rows.middleCols(kCore, shared_errors()) = prior().shared.topRows<6>();
    return rows;
  }
  /// The textbook's positions in nav, and the frame of the map, moved by some errors.
  Eigen::Vector3d position(LandmarkId id, const Eigen::VectorXd& e) const {
    const Eigen::Vector3d before =
        id < kFirstMapId ? first.at(id) : nav_T_map * map->points[index(id)].p_map;
    return before + by_errors(id) * (mean + e);
  }
  SE3 frame(const Eigen::VectorXd& e) const {
    const Vector6d by = frame_by_errors() * (mean + e);
    return {so3::exp(by.head<3>()) * nav_T_map.R, nav_T_map.p + by.tail<3>()};
  }
  static std::size_t index(LandmarkId id) { return static_cast<std::size_t>(id - kFirstMapId); }

  Random random;
  SE3 nav_T_map = level_pose(0.8, {2, -1, 0.5});  ///< when it was found
  std::shared_ptr<const LandmarkMap> map;
  Eigen::MatrixXd P;
  Eigen::VectorXd mean;  ///< of the errors of what is constant, by all updates
  Ekf filter;
  PlacedMap placed;
  std::map<LandmarkId, Eigen::Vector3d> first;  ///< own landmarks, as they were initialised
  std::map<LandmarkId, int> left;               ///< numbers of those that left the state

 private:
  int column_of_point(int i) const { return kCore + shared_errors() + 3 * i; }

  Ekf started() {
    State x{.world_T_imu = nav_T_map * SE3{Eigen::Matrix3d::Identity(), {-3, 0, 0}},
            .v_world = Eigen::Vector3d(1, 0, 0),
            .additive = Eigen::VectorXd::Zero(6)};
    P = random_covariance(random, kCore, 0.03);
    mean = Eigen::VectorXd::Zero(kCore);
    return {kStandardChart, x, P, kRecalling};
  }

  // Further independent errors.
  void append(const Eigen::MatrixXd& covariance) {
    const Eigen::Index n = P.rows(), k = covariance.rows();
    P.conservativeResizeLike(Eigen::MatrixXd::Zero(n + k, n + k));
    P.bottomRightCorner(k, k) = covariance;
    mean.conservativeResizeLike(Eigen::VectorXd::Zero(n + k));
  }

  void initialise(LandmarkId id, const Eigen::Vector3d& p_map) {
    NewLandmark fresh;
    fresh.id = id;
    fresh.p_world = first[id] = nav_T_map * p_map;
    for (int j = 0; j < 6; ++j) fresh.d_pose.col(j) = random.normal_vector(3);
    fresh.noise = random_covariance(random, 3, 0.1);
    fresh.observations = 20;
    filter.add({&fresh, 1});
    append(fresh.noise);
    const Eigen::Index at = P.rows() - 3;
    P.bottomRows<3>().leftCols(at) = fresh.d_pose * P.topRows<6>().leftCols(at);
    P.rightCols<3>().topRows(at) = P.bottomRows<3>().leftCols(at).transpose();
    P.bottomRightCorner<3, 3>() +=
        fresh.d_pose * P.topLeftCorner<6, 6>() * fresh.d_pose.transpose();
  }

  // All landmarks of the state by one camera.
  void observe() {
    const State& x = filter.state();
    const Camera camera = inertial_cameras().front();
    std::vector<Measurement> all;
    for (int i = 0; i < static_cast<int>(x.landmarks.size()); ++i) {
      auto z = measure_pixel(camera, 2, x, i, Eigen::Vector2d::Zero());
      if (!z) continue;
      z->residual = random.normal_vector(2);
      all.push_back(*z);
    }
    const DenseMeasurement z = dense_measurement(x, all);
    Eigen::MatrixXd errors = Eigen::MatrixXd::Zero(x.size(), P.cols());
    errors.topLeftCorner<kCore, kCore>().setIdentity();
    for (const Landmark& l : x.landmarks) errors.middleRows<3>(l.row) = by_errors(l.id);
    const Eigen::MatrixXd H = z.H * errors;
    const Eigen::MatrixXd K = P * H.transpose() * (H * P * H.transpose() + z.R).inverse();
    const Eigen::MatrixXd I_KH = Eigen::MatrixXd::Identity(P.rows(), P.cols()) - K * H;
    P = (I_KH * P * I_KH.transpose() + K * z.R * K.transpose()).eval();
    mean += K * z.r;
    filter.update(all);
  }

  void walk() {
    const State& x = filter.state();
    Prediction step{.world_T_imu = x.world_T_imu,
                    .v_world = x.v_world,
                    .additive = x.additive,
                    .F = Eigen::MatrixXd::Identity(kCore, kCore),
                    .Q = random_covariance(random, kCore, 0.02)};
    for (int j = 0; j < kCore; ++j) step.F.col(j) += 0.05 * random.normal_vector(kCore);
    step.world_T_imu.p += 0.2 * random.normal_vector(3);
    filter.propagate(step);
    Eigen::MatrixXd F = Eigen::MatrixXd::Identity(P.rows(), P.cols());
    F.topLeftCorner<kCore, kCore>() = step.F;
    P = (F * P * F.transpose()).eval();
    P.topLeftCorner<kCore, kCore>() += step.Q;
  }

  void leave(const std::vector<int>& indices) {
    for (const int i : indices) {
      left[filter.state().landmarks[static_cast<std::size_t>(i)].id] =
          filter.past().states() + static_cast<int>(left.size());
    }
    filter.retire(indices);
  }
};

}  // namespace chasles::test
