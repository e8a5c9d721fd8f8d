#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <chasles/initialise/dynamic_system.hpp>

namespace chasles {
namespace {

constexpr double kBehind = 20;  // residual of a point behind the camera, in standard deviations

// The direction in which a view observes its track's point, and its derivatives. With h = (a, b,
// 1), rho the inverse depth, A the anchor and I the view's keyframe:
//   q = C R_I^T [R_A (B h + rho c_A) + rho (p_A - p_I)] + rho c_I,
// scaled by the depth.
struct PointProjection {
  Eigen::Vector3d q;
  Eigen::Matrix3d d_anchor_rotation, d_rotation, d_position, d_point;  // d_anchor_p = -d_position
};

// The extrinsics of a view's camera at the line of its pixel. What accelerations add to its place
// during a readout is below a millimetre.
SE3 imu_T_camera(const MotionWindow& window, const MotionUnknowns& motion, const PlaneView& view) {
  const SE3& known = window.imu_T_cam[static_cast<std::size_t>(view.axes)];
  if (view.delay == 0) return known;
  const InertialState& at = motion.keyframes[static_cast<std::size_t>(view.keyframe)];
  const SE3 imu_T_line{.R = view.imu_R_line,
                       .p = view.delay * (at.world_T_imu.R.transpose() * at.v_world)};
  return imu_T_line * known;
}

PointProjection projection(const MotionWindow& window, const MotionUnknowns& motion,
                           const PlaneView& anchor, const Eigen::Vector3d& point,
                           const PlaneView& view) {
  const SE3 imu_T_anchor = imu_T_camera(window, motion, anchor);
  const SE3 cam_T_imu = view.delay == 0 ? window.cam_T_imu[static_cast<std::size_t>(view.axes)]
                                        : imu_T_camera(window, motion, view).inverse();
  const SE3& A = motion.keyframes[static_cast<std::size_t>(anchor.keyframe)].world_T_imu;
  const SE3& I = motion.keyframes[static_cast<std::size_t>(view.keyframe)].world_T_imu;
  const double rho = point.z();
  const Eigen::Vector3d h(point.x(), point.y(), 1);
  const Eigen::Vector3d in_anchor = A.R * (imu_T_anchor.R * h + rho * imu_T_anchor.p);
  const Eigen::Vector3d w = in_anchor + rho * (A.p - I.p);
  const Eigen::Matrix3d C = cam_T_imu.R * I.R.transpose();
  PointProjection s{.q = C * w + rho * cam_T_imu.p,
                    .d_anchor_rotation = -C * hat(in_anchor),
                    .d_rotation = C * hat(w),
                    .d_position = -rho * C,
                    .d_point = C * A.R * imu_T_anchor.R};
  s.d_point.col(2) = C * (A.R * imu_T_anchor.p + A.p - I.p) + cam_T_imu.p;
  return s;
}

bool in_front(const Eigen::Vector3d& q) { return q.z() > 1e-3 * q.norm(); }

int position_of(const std::vector<int>& keyframes, int keyframe) {
  return static_cast<int>(std::ranges::lower_bound(keyframes, keyframe) - keyframes.begin());
}

std::vector<int> keyframes_of(const PlaneTrack& track) {
  std::vector<int> keyframes;
  for (const PlaneView& view : track) {
    if (keyframes.empty() || keyframes.back() != view.keyframe) keyframes.push_back(view.keyframe);
  }
  return keyframes;
}

// A view's residual with the Huber loss, and its derivatives by the direction q.
struct WeightedView {
  double squares = kBehind * kBehind;  // without loss
  double cost = 0;
  Eigen::Vector2d r = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, 3> by_q = Eigen::Matrix<double, 2, 3>::Zero();  // 0: behind the camera
};

WeightedView weighted(const PlaneView& view, const Eigen::Vector3d& q, double huber) {
  if (!in_front(q)) return {.cost = huber * (kBehind - huber / 2)};
  const double z = q.z();
  WeightedView w;
  w.by_q << 1 / z, 0, -q.x() / (z * z), 0, 1 / z, -q.y() / (z * z);
  w.r = view.whitening * (q.head<2>() / z - view.xy);
  const double norm = w.r.norm();
  w.squares = norm * norm;
  w.cost = norm <= huber ? norm * norm / 2 : huber * (norm - huber / 2);
  const double root = norm <= huber ? 1 : std::sqrt(huber / norm);
  w.r *= root;
  w.by_q = (root * view.whitening * w.by_q).eval();
  return w;
}

void add_view(const MotionWindow& window, const MotionWeights& weights,
              const MotionUnknowns& motion, std::size_t index, const PlaneView& view,
              MotionSystem& system) {
  const PlaneView& anchor = window.tracks[index].front();
  const PointProjection s = projection(window, motion, anchor, motion.points[index], view);
  const WeightedView w = weighted(view, s.q, weights.huber);
  system.cost += w.cost;
  system.squares += w.squares;
  if (!in_front(s.q)) return;
  Eigen::Matrix<double, 2, 12> J;  // anchor's rotation, position; the view's
  J << w.by_q * s.d_anchor_rotation, -w.by_q * s.d_position, w.by_q * s.d_rotation,
      w.by_q * s.d_position;
  const Eigen::Matrix<double, 2, 3> J_point = w.by_q * s.d_point;

  MotionSystem::Track& track = system.tracks[index];
  track.H_point += J_point.transpose() * J_point;
  track.b_point -= J_point.transpose() * w.r;
  const int columns[2] = {9 * anchor.keyframe, 9 * view.keyframe};
  const int rows[2] = {0, 6 * position_of(track.keyframes, view.keyframe)};
  for (int i = 0; i < 2; ++i) {
    const auto Ji = J.middleCols<6>(6 * i);
    system.b.segment<6>(columns[i]) -= Ji.transpose() * w.r;
    track.H_pose_point.middleRows<6>(rows[i]) += Ji.transpose() * J_point;
    for (int j = 0; j < 2; ++j) {
      system.H.block<6, 6>(columns[i], columns[j]) += Ji.transpose() * J.middleCols<6>(6 * j);
    }
  }
}

void add_track(const MotionWindow& window, const MotionWeights& weights,
               const MotionUnknowns& motion, std::size_t index, MotionSystem& system) {
  MotionSystem::Track& track = system.tracks[index];
  track.keyframes = keyframes_of(window.tracks[index]);
  track.H_pose_point = Eigen::MatrixXd::Zero(6 * std::ssize(track.keyframes), 3);
  track.H_point.setZero();
  track.b_point.setZero();
  for (const PlaneView& view : window.tracks[index]) {
    add_view(window, weights, motion, index, view, system);
  }
}

// Residual: the later keyframe against the prediction from the earlier one by the samples.
void add_imu(const MotionUnknowns& motion, const Preintegration& between, const Matrix9d& W_imu,
             const Eigen::Vector3d& gravity, std::size_t k, MotionSystem& system) {
  const InertialState& now = motion.keyframes[k];
  Matrix9d W = W_imu;
  for (int i = 0; i < 9; i += 3) {
    W.middleCols<3>(i) = W_imu.middleCols<3>(i) * now.world_T_imu.R.transpose();
  }
  const InertialState& next = motion.keyframes[k + 1];
  const InertialState expected = moved(now, between, gravity);
  Eigen::Matrix<double, 9, 1> r;
  r << so3::log(next.world_T_imu.R * expected.world_T_imu.R.transpose()),
      next.world_T_imu.p - expected.world_T_imu.p, next.v_world - expected.v_world;
  const Eigen::Vector3d phi = r.head<3>();
  Eigen::Matrix<double, 9, 15> F = d_moved(now, between);
  F.topRows<3>() = (so3::right_jacobian_inverse(phi) * F.topRows<3>()).eval();
  Matrix9d next_J = Matrix9d::Identity();
  next_J.topLeftCorner<3, 3>() = so3::left_jacobian_inverse(phi);
  r = W * r;
  Eigen::Matrix<double, 9, 24> J;  // this keyframe, the next one, biases
  J << -W * F.leftCols<9>(), W * next_J, -W * F.rightCols<6>();
  const Eigen::Matrix<double, 24, 24> H = J.transpose() * J;
  const Eigen::Matrix<double, 24, 1> b = -J.transpose() * r;
  const int at = 9 * static_cast<int>(k), biases = static_cast<int>(system.H.rows()) - 6;
  system.H.block<18, 18>(at, at) += H.topLeftCorner<18, 18>();
  system.H.block<18, 6>(at, biases) += H.topRightCorner<18, 6>();
  system.H.block<6, 18>(biases, at) += H.bottomLeftCorner<6, 18>();
  system.H.bottomRightCorner<6, 6>() += H.bottomRightCorner<6, 6>();
  system.b.segment<18>(at) += b.head<18>();
  system.b.tail<6>() += b.tail<6>();
  system.cost += r.squaredNorm() / 2;
}

// Fixes heading and position of keyframe 0.
void hold_gauge(ReducedSystem& system) {
  for (const int row : {2, 3, 4, 5}) {
    system.H.row(row).setZero();
    system.H.col(row).setZero();
    system.H(row, row) = 1;
    system.b[row] = 0;
  }
}

Eigen::Matrix3d damped_inverse(const Eigen::Matrix3d& H, double damping) {
  Eigen::Matrix3d damped = H;
  damped.diagonal() *= 1 + damping;
  damped.diagonal().array() += 1e-9;  // a point with a single view has no depth
  return damped.inverse();
}

// The equations of a point alone, with the keyframes where they are.
struct PointEquations {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double cost = 0;
};

PointEquations point_equations(const MotionWindow& window, const MotionUnknowns& motion,
                               const PlaneTrack& track, const Eigen::Vector3d& point,
                               double huber) {
  PointEquations e;
  for (const PlaneView& view : track) {
    const PointProjection s = projection(window, motion, track.front(), point, view);
    const WeightedView w = weighted(view, s.q, huber);
    const Eigen::Matrix<double, 2, 3> J = w.by_q * s.d_point;
    e.H += J.transpose() * J;
    e.b -= J.transpose() * w.r;
    e.cost += w.cost;
  }
  return e;
}

void set_biases(MotionUnknowns& motion) {
  for (InertialState& state : motion.keyframes) {
    state.accelerometer_bias = motion.biases.head<3>();
    state.gyroscope_bias = motion.biases.tail<3>();
  }
}

void move(const Eigen::VectorXd& delta, std::size_t k, MotionUnknowns& motion) {
  InertialState& state = motion.keyframes[k];
  const auto d = delta.segment<9>(9 * static_cast<Eigen::Index>(k));
  state.world_T_imu.R = so3::normalized(so3::exp(d.head<3>()) * state.world_T_imu.R);
  state.world_T_imu.p += d.segment<3>(3);
  state.v_world += d.tail<3>();
}

// Derivatives of all keyframes by keyframe 0 and the biases.
Eigen::MatrixXd shooting_basis(const MotionStep& at) {
  const auto count = static_cast<Eigen::Index>(at.motion.keyframes.size());
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(9 * count + 6, 15);
  Eigen::Matrix<double, 15, 15> now = Eigen::Matrix<double, 15, 15>::Identity();
  M.topRows<9>() = now.topRows<9>();
  for (Eigen::Index k = 1; k < count; ++k) {
    const auto before = static_cast<std::size_t>(k - 1);
    now.topRows<9>() = (d_moved(at.motion.keyframes[before], at.between[before]) * now).eval();
    M.middleRows<9>(9 * k) = now.topRows<9>();
  }
  M.bottomRightCorner<6, 6>().setIdentity();
  return M;
}

std::optional<Eigen::VectorXd> solve(Eigen::MatrixXd H, const Eigen::VectorXd& b, double damping) {
  H.diagonal() *= 1 + damping;
  const Eigen::LLT<Eigen::MatrixXd> cholesky(H);
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  Eigen::VectorXd delta = cholesky.solve(b);
  if (!delta.allFinite()) return std::nullopt;
  return delta;
}

std::optional<Eigen::VectorXd> solve(const ReducedSystem& reduced, const MotionStep& from,
                                     Shooting shooting, double damping) {
  if (shooting == Shooting::kMultiple) return solve(reduced.H, reduced.b, damping);
  const Eigen::MatrixXd M = shooting_basis(from);
  ReducedSystem few{.H = M.transpose() * reduced.H * M, .b = M.transpose() * reduced.b};
  hold_gauge(few);
  const auto delta = solve(few.H, few.b, damping);
  if (!delta) return std::nullopt;
  return M * *delta;
}

// The points' part of a step.
void move_points(const MotionSystem& system, const Eigen::VectorXd& delta, double damping,
                 MotionUnknowns& motion) {
  for (std::size_t i = 0; i < system.tracks.size(); ++i) {
    const MotionSystem::Track& track = system.tracks[i];
    Eigen::Vector3d b = track.b_point;
    for (std::size_t k = 0; k < track.keyframes.size(); ++k) {
      b -= track.H_pose_point.middleRows<6>(6 * static_cast<Eigen::Index>(k)).transpose() *
           delta.segment<6>(9 * track.keyframes[k]);
    }
    motion.points[i] += damped_inverse(track.H_point, damping) * b;
  }
}

}  // namespace

std::optional<Eigen::Vector2d> view_residual(const MotionWindow& window,
                                             const MotionUnknowns& motion, std::size_t track,
                                             const PlaneView& view) {
  const PointProjection s =
      projection(window, motion, window.tracks[track].front(), motion.points[track], view);
  if (!in_front(s.q)) return std::nullopt;
  return view.whitening * (s.q.head<2>() / s.q.z() - view.xy);
}

MotionSystem linearise(const MotionWindow& window, const std::vector<Preintegration>& between,
                       const MotionWeights& weights, const MotionUnknowns& motion) {
  const Eigen::Index n = 9 * std::ssize(motion.keyframes) + 6;
  MotionSystem system{
      .H = Eigen::MatrixXd::Zero(n, n), .b = Eigen::VectorXd::Zero(n), .tracks = {}};
  system.tracks.resize(window.tracks.size());
  for (std::size_t i = 0; i < window.tracks.size(); ++i) {
    add_track(window, weights, motion, i, system);
  }
  const Eigen::Vector3d gravity(0, 0, -weights.gravity);
  for (std::size_t k = 0; k < between.size(); ++k) {
    add_imu(motion, between[k], weights.imu[k], gravity, k, system);
  }
  const Vector6d information = weights.bias_sigma.cwiseAbs2().cwiseInverse();
  system.H.diagonal().tail<6>() += information;
  system.b.tail<6>() -= information.cwiseProduct(motion.biases);
  system.cost += motion.biases.cwiseAbs2().dot(information) / 2;
  return system;
}

void optimise_points(const MotionWindow& window, const MotionWeights& weights,
                     MotionUnknowns& motion) {
  constexpr int kIterations = 3;
  constexpr double kConverged = 1e-3;  // decrease of the cost, relative to the cost
  for (std::size_t i = 0; i < window.tracks.size(); ++i) {
    const auto equations_at = [&](const Eigen::Vector3d& point) {
      return point_equations(window, motion, window.tracks[i], point, weights.huber);
    };
    Eigen::Vector3d& point = motion.points[i];
    PointEquations here = equations_at(point);
    double damping = 0;
    for (int k = 0; k < kIterations; ++k) {
      const Eigen::Vector3d next = point + damped_inverse(here.H, damping) * here.b;
      const PointEquations there = equations_at(next);
      if (!(there.cost < here.cost)) {
        damping = std::max(1e-3, 10 * damping);
        continue;
      }
      const bool converged = here.cost - there.cost < kConverged * here.cost;
      point = next;
      here = there;
      if (converged) break;
    }
  }
}

ReducedSystem eliminate_points(const MotionSystem& system, double damping) {
  ReducedSystem reduced{.H = system.H, .b = system.b};
  for (const MotionSystem::Track& track : system.tracks) {
    const Eigen::MatrixXd gain = track.H_pose_point * damped_inverse(track.H_point, damping);
    const Eigen::MatrixXd outer = gain * track.H_pose_point.transpose();
    const Eigen::VectorXd side = gain * track.b_point;
    const auto count = static_cast<Eigen::Index>(track.keyframes.size());
    for (Eigen::Index i = 0; i < count; ++i) {
      const int row = 9 * track.keyframes[static_cast<std::size_t>(i)];
      reduced.b.segment<6>(row) -= side.segment<6>(6 * i);
      for (Eigen::Index j = 0; j < count; ++j) {
        const int column = 9 * track.keyframes[static_cast<std::size_t>(j)];
        reduced.H.block<6, 6>(row, column) -= outer.block<6, 6>(6 * i, 6 * j);
      }
    }
  }
  hold_gauge(reduced);
  return reduced;
}

std::optional<MotionStep> take_step(const MotionWindow& window, const MotionSystem& system,
                                    const MotionStep& from, double gravity, Shooting shooting,
                                    double damping) {
  const auto delta = solve(eliminate_points(system, damping), from, shooting, damping);
  if (!delta) return std::nullopt;
  MotionStep next = from;
  move_points(system, *delta, damping, next.motion);
  next.motion.biases += delta->tail<6>();
  set_biases(next.motion);
  for (std::size_t k = 0; k < next.between.size(); ++k) {
    chasles::set_biases(window.intervals[k], next.motion.biases, next.between[k]);
  }
  move(*delta, 0, next.motion);
  for (std::size_t k = 1; k < next.motion.keyframes.size(); ++k) {
    if (shooting == Shooting::kMultiple) {
      move(*delta, k, next.motion);
    } else {
      next.motion.keyframes[k] =
          moved(next.motion.keyframes[k - 1], next.between[k - 1], {0, 0, -gravity});
    }
  }
  return next;
}

}  // namespace chasles
