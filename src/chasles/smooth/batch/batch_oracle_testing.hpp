#pragma once

#include <chasles/smooth/batch/smooth_testing.hpp>

// The same minimum by the simplest method, for a few keyframes: dense Gauss-Newton steps, residuals
// in world axes, numeric derivatives, and the covariance of the samples' noise by numeric
// derivatives. It shares only the integration of a sample, the projection of a point and SO(3) with
// the product.
namespace chasles::test {

class BatchOracle {
 public:
  explicit BatchOracle(const SmallScene& scene) : in_(scene.input) {
    ImuBuffer buffer(in_.imu);
    for (const ImuSample& sample : in_.samples) buffer.add(sample);
    states_.push_back({.world_T_imu = in_.start.nav_T_imu,
                       .v_world = in_.start.v_nav,
                       .accelerometer_bias = in_.start.accelerometer_bias,
                       .gyroscope_bias = in_.start.gyroscope_bias});
    for (std::size_t k = 0; k + 1 < in_.frames.size(); ++k) {
      between_.push_back(buffer.between(in_.frames[k].time, in_.frames[k + 1].time));
      noise_.push_back(noise_roots(between_.back()));
      states_.push_back(integrated(states_.back(), between_.back()));
    }
    for (const auto& [id, p] : scene.landmarks) points_[id] = p;
  }

  void solve(int steps) {
    for (int i = 0; i < steps; ++i) {
      const Eigen::VectorXd zero = Eigen::VectorXd::Zero(size());
      const Eigen::VectorXd r = residual(zero);
      J_ = numeric_derivative([this](const Eigen::VectorXd& e) { return residual(e); }, zero, 1e-5);
      move(-(J_.transpose() * J_).ldlt().solve(J_.transpose() * r));
    }
  }

  const std::vector<InertialState>& states() const { return states_; }
  const std::map<LandmarkId, Eigen::Vector3d>& points() const { return points_; }
  Eigen::MatrixXd covariance() const { return covariance_of(J_); }
  double cost() { return residual(Eigen::VectorXd::Zero(size())).squaredNorm() / 2; }

 private:
  using Vector15 = Eigen::Matrix<double, 15, 1>;

  Eigen::Index size() const {
    return 15 * std::ssize(states_) + 3 * static_cast<Eigen::Index>(points_.size());
  }
  static Vector15 difference(const InertialState& a, const InertialState& b) {
    Vector15 d;
    d << so3::log(a.world_T_imu.R * b.world_T_imu.R.transpose()), a.world_T_imu.p - b.world_T_imu.p,
        a.v_world - b.v_world, a.accelerometer_bias - b.accelerometer_bias,
        a.gyroscope_bias - b.gyroscope_bias;
    return d;
  }

  // Covariance of the state after the intervals, from zero velocity and level attitude: the two
  // noises and two walks of every interval in turn.
  Eigen::MatrixXd noise_roots(const std::vector<ImuInterval>& intervals) const {
    InertialState start;
    start.accelerometer_bias = in_.start.accelerometer_bias;
    start.gyroscope_bias = in_.start.gyroscope_bias;
    const auto n = 12 * std::ssize(intervals);
    const auto end = [&](const Eigen::VectorXd& e) {
      InertialState s = start;
      for (std::size_t i = 0; i < intervals.size(); ++i) {
        ImuInterval interval = intervals[i];
        const Eigen::VectorXd d = e.segment(12 * static_cast<Eigen::Index>(i), 12);
        interval.specific_force_imu += d.head<3>();
        interval.angular_rate_imu += d.segment<3>(3);
        s = integrate(s, interval, Eigen::Vector3d::Zero());
        s.accelerometer_bias += d.segment<3>(6);
        s.gyroscope_bias += d.tail<3>();
      }
      return s;
    };
    const InertialState mean = end(Eigen::VectorXd::Zero(n));
    Eigen::MatrixXd D = numeric_derivative(
        [&](const Eigen::VectorXd& e) -> Eigen::VectorXd { return difference(end(e), mean); },
        Eigen::VectorXd(Eigen::VectorXd::Zero(n)));
    for (std::size_t i = 0; i < intervals.size(); ++i) {
      const double root = std::sqrt(intervals[i].tau);
      const double sigmas[4] = {
          in_.noise.accelerometer_noise_density / root, in_.noise.gyroscope_noise_density / root,
          in_.noise.accelerometer_random_walk * root, in_.noise.gyroscope_random_walk * root};
      for (int j = 0; j < 4; ++j) {
        D.middleCols(12 * static_cast<Eigen::Index>(i) + 3 * j, 3) *= sigmas[j];
      }
    }
    return D * D.transpose();
  }

  static Eigen::VectorXd whitened(const Eigen::MatrixXd& P, const Eigen::VectorXd& r) {
    const Eigen::VectorXd s = P.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd unit = s.asDiagonal() * P * s.asDiagonal();
    return unit.llt().matrixL().solve(s.cwiseProduct(r));
  }

  Eigen::VectorXd residual(const Eigen::VectorXd& e) const {
    std::vector<InertialState> states;
    for (std::size_t k = 0; k < states_.size(); ++k) {
      states.push_back(moved(states_[k], e.segment<15>(15 * static_cast<Eigen::Index>(k))));
    }
    std::vector<double> all;
    const auto add = [&](const Eigen::VectorXd& r) { all.insert(all.end(), r.begin(), r.end()); };
    const InertialState start{.world_T_imu = in_.start.nav_T_imu,
                              .v_world = in_.start.v_nav,
                              .accelerometer_bias = in_.start.accelerometer_bias,
                              .gyroscope_bias = in_.start.gyroscope_bias};
    Eigen::MatrixXd P0 = in_.start_covariance;
    P0.diagonal().head(12).array() += 1e-12;
    P0.diagonal().tail(3).array() += 1e-16;
    add(whitened(P0, difference(states.front(), start)));
    for (std::size_t k = 0; k + 1 < states.size(); ++k) {
      Vector15 r = difference(states[k + 1], integrated(states[k], between_[k]));
      for (int i = 0; i < 9; i += 3) {
        r.segment<3>(i) = states[k].world_T_imu.R.transpose() * r.segment<3>(i);
      }
      add(whitened(noise_[k], r));
    }
    Eigen::Index at = 15 * std::ssize(states_);
    for (const auto& [id, p] : points_) {
      const Eigen::Vector3d moved_p = p + e.segment<3>(at);
      at += 3;
      int matches = 0;
      for (std::size_t k = 0; k < in_.frames.size(); ++k) {
        for (const PixelObservation& o : in_.frames[k].pixels) {
          if (o.landmark != id) continue;
          const Camera& camera = in_.cameras[static_cast<std::size_t>(o.camera)];
          const auto seen =
              project(camera, camera.cam_T_imu * (states[k].world_T_imu.inverse() * moved_p));
          double variance = in_.pixel_sigma * in_.pixel_sigma;
          if (o.camera > 0) {
            ++matches;
            variance += in_.match_sigma * in_.match_sigma * matches * (matches + 1);
          }
          add((seen.value().pixel - o.pixel) / std::sqrt(variance));
        }
      }
    }
    return Eigen::Map<Eigen::VectorXd>(all.data(), std::ssize(all));
  }

  void move(const Eigen::VectorXd& e) {
    for (std::size_t k = 0; k < states_.size(); ++k) {
      states_[k] = moved(states_[k], e.segment<15>(15 * static_cast<Eigen::Index>(k)));
    }
    Eigen::Index at = 15 * std::ssize(states_);
    for (auto& [id, p] : points_) {
      p += e.segment<3>(at);
      at += 3;
    }
  }

  const InertialBatchInput& in_;
  std::vector<std::vector<ImuInterval>> between_;
  std::vector<Eigen::MatrixXd> noise_;
  std::vector<InertialState> states_;
  std::map<LandmarkId, Eigen::Vector3d> points_;
  Eigen::MatrixXd J_;
};

}  // namespace chasles::test
