#pragma once

#include <chasles/smooth/batch/smooth_testing.hpp>
#include <chasles/smooth/batch/velocity_testing.hpp>

// The same minimum by the simplest method, for a few frames: dense Gauss-Newton steps, numeric
// derivatives, the twist between two poses by a series. It shares only the projection of a point
// and SO(3) with the product.
namespace chasles::test {

class VelocityOracle {
 public:
  /// Velocities and frames must have the same times, and every frame is a keyframe.
  explicit VelocityOracle(const DriveScene& scene)
      : in_(scene.input), model_(model_of(scene.input.settings, scene.input.noise)) {
    for (const TrueDrive& t : scene.truth) states_.push_back(t);  // initial values of the search
    for (const auto& [id, p] : scene.landmarks) points_[id] = p;
  }

  void solve(int steps) {
    for (int i = 0; i < steps; ++i) {
      const Eigen::VectorXd zero = Eigen::VectorXd::Zero(size());
      const Eigen::VectorXd r = residual(zero);
      J_ = numeric_derivative([this](const Eigen::VectorXd& e) { return residual(e); }, zero, 1e-5);
      move(-inverse() * (J_.transpose() * r));
    }
  }

  const std::vector<TrueDrive>& states() const { return states_; }
  const std::map<LandmarkId, Eigen::Vector3d>& points() const { return points_; }
  const Eigen::MatrixXd& jacobian() const { return J_; }  ///< of the last step
  Eigen::MatrixXd inverse() const { return covariance_of(J_); }
  double cost() { return residual(Eigen::VectorXd::Zero(size())).squaredNorm() / 2; }
  int state_size() const { return 6 + model_.size(); }

 private:
  Eigen::Index size() const {
    return state_size() * std::ssize(states_) + 3 * static_cast<Eigen::Index>(points_.size());
  }

  // p = (sum of hat(phi)^i / (i + 1)!) rho.
  static Vector6d twist(const SE3& now, const SE3& next) {
    const Eigen::Matrix3d Rt = now.R.transpose();
    const Eigen::Vector3d phi = so3::log(Rt * next.R);
    Eigen::Matrix3d V = Eigen::Matrix3d::Zero(), power = Eigen::Matrix3d::Identity();
    for (int i = 0; i < 25; ++i) {
      V += power;
      power = (power * hat(phi) / (i + 2)).eval();
    }
    Vector6d xi;
    xi << phi, V.inverse() * (Rt * (next.p - now.p));
    return xi;
  }

  TrueDrive moved(const TrueDrive& s, const Eigen::VectorXd& e) const {
    TrueDrive m = s;
    m.world_T_imu.R = so3::exp(e.head<3>()) * m.world_T_imu.R;
    m.world_T_imu.p += e.segment<3>(3);
    m.additive += e.tail(model_.size());
    return m;
  }

  double scale(const TrueDrive& s) const {
    return model_.scale ? std::exp(s.additive[model_.scale_index()]) : 1;
  }

  void add_start(const TrueDrive& first, std::vector<double>& all) const {
    const Eigen::VectorXd P = initial_covariance(in_.settings, in_.noise).diagonal();
    Eigen::VectorXd e(state_size());
    e << so3::log(first.world_T_imu.R), first.world_T_imu.p, first.additive;
    for (Eigen::Index i = 0; i < e.size(); ++i) {
      const bool rate = i >= 6 + model_.bias_index() && i < 9 + model_.bias_index();
      all.push_back(e[i] / std::sqrt(P[i] + (rate ? 1e-16 : 1e-12)));
    }
  }

  // Two correlated integrals, axis by axis: the uncertainty of the path from the velocity's change.
  void add_link(std::size_t k, const TrueDrive& a, const TrueDrive& b,
                std::vector<double>& all) const {
    const BodyVelocityNoise& noise = in_.noise.motion;
    const double tau = to_seconds(b.time - a.time);
    Vector6d xi = twist(a.world_T_imu, b.world_T_imu);
    const Eigen::VectorXd change = b.additive - a.additive;
    if (model_.velocity_state) {
      for (int i = 0; i < 6; ++i) {
        const double beyond = xi[i] - tau * a.additive[i] - tau / 2 * change[i];
        all.push_back(beyond / (noise.walk[i] * std::sqrt(tau * tau * tau / 12)));
        all.push_back(change[i] / (noise.walk[i] * std::sqrt(tau)));
      }
    } else {
      Vector6d said = tau * (Vector6d() << in_.velocities[k].angular_imu -
                                               a.additive.segment<3>(model_.bias_index()),
                             in_.velocities[k].linear_imu / scale(a))
                                .finished();
      Vector6d sigma = tau * noise.sample_sigma;
      sigma.tail<3>() /= scale(a);
      for (int i = 0; i < 6; ++i) all.push_back((xi[i] - said[i]) / sigma[i]);
    }
    for (int i = 0; i < 3; ++i) {
      all.push_back(change[model_.bias_index() + i] / (noise.gyro_bias_walk * std::sqrt(tau)));
    }
    for (int i = 0; model_.level && i < 3; ++i) {
      const double walk = i < 2 ? noise.tilt_walk : noise.heading_walk;
      all.push_back(change[model_.tilt_index() + i] / (walk * std::sqrt(tau)));
    }
    if (model_.scale) {
      all.push_back(change[model_.scale_index()] / (noise.scale_walk * std::sqrt(tau)));
    }
  }

  void add_sample(std::size_t k, const TrueDrive& s, std::vector<double>& all) const {
    if (!model_.velocity_state) return;
    Vector6d u = s.additive.head<6>();
    u.tail<3>() *= scale(s);
    if (model_.level) {
      drive_scene_detail::make_level(s.world_T_imu.R, s.additive.segment<3>(model_.tilt_index()),
                                     u);
    }
    const Eigen::Vector3d w = u.head<3>() + s.additive.segment<3>(model_.bias_index());
    const Eigen::Vector3d v = u.tail<3>();
    for (int i = 0; i < 3; ++i) {
      const Vector6d& sigma = in_.noise.motion.sample_sigma;
      all.push_back((in_.velocities[k].angular_imu[i] - w[i]) / sigma[i]);
      all.push_back((in_.velocities[k].linear_imu[i] - v[i]) / sigma[3 + i]);
    }
  }

  void add_observation(const StereoObservation& o, const Eigen::Vector4d& predicted, bool first,
                       std::vector<double>& all) const {
    const StereoNoise& sigma = first ? in_.noise.initialisation : in_.noise.update;
    const Eigen::Vector4d d = o.pixels - predicted;
    if (!first && in_.settings.stereo_rows == StereoRows::kAll) {
      for (int i = 0; i < 4; ++i) all.push_back(d[i] / sigma.u);
      return;
    }
    all.push_back((d[0] + d[2]) / 2 / sigma.u);
    all.push_back((d[1] + d[3]) / 2 / sigma.v);
    if (first || in_.settings.stereo_rows != StereoRows::kMean) {
      all.push_back((d[0] - d[2]) / sigma.disparity);
    }
  }

  Eigen::VectorXd residual(const Eigen::VectorXd& e) const {
    std::vector<TrueDrive> states;
    const Eigen::Index n = state_size();
    for (std::size_t k = 0; k < states_.size(); ++k) {
      states.push_back(moved(states_[k], e.segment(n * static_cast<Eigen::Index>(k), n)));
    }
    std::vector<double> all;
    add_start(states.front(), all);
    for (std::size_t k = 0; k < states.size(); ++k) {
      add_sample(k, states[k], all);
      if (k + 1 < states.size()) add_link(k, states[k], states[k + 1], all);
    }
    Eigen::Index at = n * std::ssize(states_);
    for (const auto& [id, p] : points_) {
      const Eigen::Vector3d moved_p = p + e.segment<3>(at);
      at += 3;
      bool first = true;
      for (std::size_t k = 0; k < in_.frames.size(); ++k) {
        for (const StereoObservation& o : in_.frames[k].observations) {
          if (o.landmark != id) continue;
          const SE3 cam0_T_world = in_.rig.cam0_T_imu * states[k].world_T_imu.inverse();
          add_observation(o, project(in_.rig, cam0_T_world * moved_p)->pixels, first, all);
          first = false;
        }
      }
    }
    return Eigen::Map<Eigen::VectorXd>(all.data(), std::ssize(all));
  }

  void move(const Eigen::VectorXd& e) {
    const Eigen::Index n = state_size();
    for (std::size_t k = 0; k < states_.size(); ++k) {
      states_[k] = moved(states_[k], e.segment(n * static_cast<Eigen::Index>(k), n));
    }
    Eigen::Index at = n * std::ssize(states_);
    for (auto& [id, p] : points_) {
      p += e.segment<3>(at);
      at += 3;
    }
  }

  const VelocityBatchInput& in_;
  BodyVelocityModel model_;
  std::vector<TrueDrive> states_;
  std::map<LandmarkId, Eigen::Vector3d> points_;
  Eigen::MatrixXd J_;
};

}  // namespace chasles::test
