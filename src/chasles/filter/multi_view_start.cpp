#include <algorithm>
#include <cmath>

#include <Eigen/Householder>
#include <Eigen/LU>

#include <chasles/base/time.hpp>
#include <chasles/filter/calibration.hpp>
#include <chasles/filter/multi_view_start.hpp>
#include <chasles/filter/pixel_projection.hpp>
#include <chasles/lie/small_matrices.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
template <class Matrix>
using Map = Eigen::Map<Matrix, Eigen::AlignedMax>;

constexpr Index kRowsOfAMeasurement = 6;

// r = H_others d_others + H_point d_point + n
struct Linear {
  Map<VectorXd> r;
  Map<MatrixXd> H_point;   // three columns
  Map<MatrixXd> H_others;  // six columns for each of the scratch's rows
};

// The views with the estimated cameras and poses, and the rows that they depend on.
void gather_poses(std::span<const Camera> cameras, const State& x,
                  std::span<const ClonedView> views, MultiViewScratch& s) {
  s.cameras.clear();
  s.cameras.reserve(cameras.size() + views.size());
  for (const Camera& camera : cameras) {
    s.cameras.push_back(as_estimated(camera, x, static_cast<int>(s.cameras.size())));
  }
  s.views.clear();
  for (const ClonedView& view : views) {
    const Clone& clone = x.clone(view.clone);
    const Camera* camera = &s.cameras[static_cast<std::size_t>(view.camera)];
    if (camera->shutter.is_rolling()) {
      camera = &s.cameras.emplace_back(at_line(*camera, clone.readout, view.pixel));
    }
    s.views.push_back({.world_T_imu = clone.world_T_imu, .camera = camera, .pixel = view.pixel});
  }
  s.rows.clear();
  const auto note = [&](int row) {
    if (std::find(s.rows.begin(), s.rows.end(), row) == s.rows.end()) s.rows.push_back(row);
  };
  for (const ClonedView& view : views) note(x.clone(view.clone).row);
  for (const ClonedView& view : views) {
    if (const auto row = x.camera_row(view.camera)) note(*row);
    if (const auto row = x.intrinsics_row(view.camera)) {
      const int blocks = x.intrinsics[static_cast<std::size_t>(view.camera)].blocks();
      for (int i = 0; i < blocks; ++i) note(*row + 6 * i);
    }
  }
}

Index column_of(int row, const MultiViewScratch& s) {
  return 6 * (std::find(s.rows.begin(), s.rows.end(), row) - s.rows.begin());
}

// None if the point has no projection in a camera.
std::optional<Linear> linearise(const State& x, std::span<const ClonedView> views,
                                const Vector3d& p_world, Linearisation at, MultiViewScratch& s) {
  const HomogeneousPoint point{p_world};
  const auto m = 2 * static_cast<Index>(views.size());
  Linear result{.r = s.r.take<VectorXd>(m),
                .H_point = s.H_point.take(m, 3),
                .H_others = s.H_others.take(m, 6 * static_cast<Index>(s.rows.size()))};
  result.H_others.setZero();
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Clone& clone = x.clone(views[i].clone);
    const Camera& camera = *s.views[i].camera;
    const auto now = see(camera, clone.world_T_imu, point, views[i].pixel);
    const bool current = at == Linearisation::kCurrent;
    const SE3& at_pose = current ? clone.world_T_imu : clone.first;
    const auto seen = current ? now : see(camera, at_pose, point, views[i].pixel);
    if (!now || !seen) return std::nullopt;
    const auto row = 2 * static_cast<Index>(i);
    result.r.segment<2>(row) = now->residual;
    result.H_point.middleRows<2>(row) = seen->d_point;
    result.H_others.block<2, 6>(row, column_of(clone.row, s)) = seen->d_pose;
    if (const auto of_camera = x.camera_row(views[i].camera)) {
      result.H_others.block<2, 6>(row, column_of(*of_camera, s)) = derivative_by_camera(
          camera, at_pose, point, seen->d_point, imu_T_line(camera, clone.readout, views[i].pixel));
    }
    if (const auto of_intrinsics = x.intrinsics_row(views[i].camera)) {
      const auto by = intrinsics_derivative(x, views[i].camera, camera, clone.readout,
                                            views[i].pixel, in_camera(camera, at_pose, point), 1);
      for (int k = 0; k < by.blocks; ++k) {
        result.H_others.block<2, 6>(row, column_of(*of_intrinsics + 6 * k, s)) = by.block(k);
      }
    }
  }
  return result;
}

// Makes the noise of all rows sigma^2 I: the rows are multiplied by L^-1, L L^T the covariance of
// the views' errors over sigma^2. Two views share the walk from the later of them to the last view,
// and two matches the error of the match.
void whiten(const State& x, std::span<const ClonedView> views, const TrackNoise& noise,
            MultiViewScratch& s, Linear& linear) {
  if (noise.is_white()) return;
  const auto is_match = [&](Index i) { return views[static_cast<std::size_t>(i)].match; };
  const auto time = [&](Index i) { return x.clone(views[static_cast<std::size_t>(i)].clone).time; };
  const auto n = static_cast<Index>(views.size());
  const Time last = time(n - 1);
  auto L = s.correlation.take(n, n);
  for (Index j = 0; j < n; ++j) {
    for (Index i = j; i < n; ++i) {
      const Time later = std::max(time(i), time(j));
      double common = noise.drift_variance(to_seconds(last - later));
      if (is_match(i) && is_match(j)) common += noise.match * noise.match;
      L(i, j) = common / (noise.sigma * noise.sigma);
    }
    L(j, j) += 1;
  }
  const auto rows_of = [](auto& M, Index i) { return M.template middleRows<2>(2 * i); };
  const auto subtract = [&](Index i, Index k) {
    rows_of(linear.r, i) -= L(i, k) * rows_of(linear.r, k);
    rows_of(linear.H_point, i) -= L(i, k) * rows_of(linear.H_point, k);
    rows_of(linear.H_others, i) -= L(i, k) * rows_of(linear.H_others, k);
  };
  for (Index i = 0; i < n; ++i) {
    for (Index k = 0; k < i; ++k) {
      for (Index j = 0; j < k; ++j) L(i, k) -= L(i, j) * L(k, j);
      L(i, k) /= L(k, k);
      L(i, i) -= L(i, k) * L(i, k);
      subtract(i, k);
    }
    L(i, i) = std::sqrt(L(i, i));
    rows_of(linear.r, i) /= L(i, i);
    rows_of(linear.H_point, i) /= L(i, i);
    rows_of(linear.H_others, i) /= L(i, i);
  }
}

// The distance from the last view, which has the clone of row `last`.
void find_distance(const Linear& linear, const MultiViewPoint& point, double sigma, int last,
                   MultiViewScratch& s, MultiViewStart& result) {
  const Vector3d from_imu = point.p_world - s.views.back().world_T_imu.p;
  const Vector3d along = from_imu.normalized();
  auto right = s.moved.take(3, linear.H_others.cols());
  right.noalias() = linear.H_point.transpose() * linear.H_others;
  const Eigen::Matrix3d normal = linear.H_point.transpose() * linear.H_point;
  auto d_point = s.d_point.take(3, right.cols());
  d_point = -right;
  small::solve_symmetric(normal, d_point);
  result.distance = from_imu.norm();
  result.distance_noise = sigma * sigma * along.dot(normal.inverse() * along);
  result.d_distance.clear();
  for (const int row : s.rows) {
    Eigen::Matrix<double, 1, 6> d = along.transpose() * d_point.middleCols<6>(column_of(row, s));
    if (row == last) d.tail<3>() -= along.transpose();
    result.d_distance.push_back({.row = row, .d = d});
  }
}

// Cartesian.
void set_point(LandmarkId id, const Vector3d& p_world, std::span<const ClonedView> views,
               NewLandmark& landmark) {
  landmark.clear();
  landmark.id = id;
  landmark.p_world = p_world;
  landmark.observations = static_cast<int>(views.size());
  landmark.matches = static_cast<int>(std::ranges::count_if(views, &ClonedView::match));
}

// Anchored in the last view, and linearised in this form.
void hang_on_anchor(const State& x, const ClonedView& last, Linearisation at, MultiViewScratch& s,
                    Linear& linear, NewLandmark& landmark) {
  Clone anchor = x.clone(last.clone);
  const SE3& of_camera = s.views.back().camera->cam_T_imu;
  const Vector3d p_cam = of_camera * (anchor.world_T_imu.inverse() * landmark.p_world);
  landmark.face = face_towards(p_cam);
  const SE3 cam_T_imu = face_T_imu(landmark.face, of_camera);
  landmark.anchor = anchor.id;
  landmark.camera = last.camera;
  landmark.cam_T_imu = cam_T_imu;
  landmark.imu_T_line = imu_T_line(*s.views.back().camera, anchor.readout, last.pixel);
  landmark.inverse_depth = inverse_depth_in(landmark.face, p_cam, 1);
  Landmark known;
  known.cam_T_imu = cam_T_imu;
  known.imu_T_line = landmark.imu_T_line;
  known.inverse_depth = landmark.inverse_depth;
  if (at == Linearisation::kFirstEstimates) anchor.world_T_imu = anchor.first;
  const Eigen::Matrix<double, 3, 9> d = anchored_derivative(anchor, known);
  linear.H_others.middleCols<6>(column_of(anchor.row, s)).noalias() +=
      linear.H_point * d.leftCols<6>();
  if (const auto camera = x.camera_row(last.camera)) {
    linear.H_others.middleCols<6>(column_of(*camera, s)).noalias() +=
        linear.H_point * anchored_derivative_by_camera(anchor, known);
  }
  auto moved = s.moved.take(linear.H_point.rows(), 3);
  moved.noalias() = linear.H_point * d.rightCols<3>();
  linear.H_point = moved;
}

// M <- H M with the reflection H = I - tau v v^T, v = (1, tail): Eigen's own function allocates
// heap memory.
template <class Tail, class Block>
void reflect(const Tail& tail, double tau, Block M, MultiViewScratch& s) {
  auto bottom = M.bottomRows(M.rows() - 1);
  auto v_M = s.workspace.take<Eigen::Matrix<double, 1, Eigen::Dynamic>>(1, M.cols());
  v_M.noalias() = tail.transpose() * bottom;
  v_M += M.row(0);
  M.row(0) -= tau * v_M;
  auto tau_tail = s.moved.take<VectorXd>(tail.size());
  tau_tail = tau * tail;
  for (Index j = 0; j < M.cols(); ++j) bottom.col(j) -= v_M[j] * tau_tail;
}

// Rotates the rows so that only the first three depend on the point, by a Householder QR of
// H_point; returns its R.
Matrix3d separate(Linear& linear, MultiViewScratch& s) {
  auto& [r, H_point, H_others] = linear;
  for (Index k = 0; k < 3; ++k) {
    const Index rows = r.size() - k;
    double tau = 0, beta = 0;
    H_point.col(k).tail(rows).makeHouseholderInPlace(tau, beta);
    H_point(k, k) = beta;
    if (tau == 0) continue;
    const auto tail = H_point.col(k).tail(rows - 1);
    reflect(tail, tau, H_point.bottomRightCorner(rows, 2 - k), s);
    reflect(tail, tau, H_others.bottomRightCorner(rows, H_others.cols()), s);
    reflect(tail, tau, r.bottomRightCorner(rows, 1), s);
  }
  return H_point.topRows<3>().triangularView<Eigen::Upper>();
}

// R d_point = r_1 - H_1 d_others - n_1. r_1 is zero only if the rows are those of the
// triangulation: current estimates, white noise.
void solve_for_point(const Linear& linear, const Matrix3d& R, double sigma, MultiViewScratch& s,
                     NewLandmark& landmark) {
  const Matrix3d R_inverse = R.triangularView<Eigen::Upper>().solve(Matrix3d::Identity());
  landmark.noise = sigma * sigma * R_inverse * R_inverse.transpose();
  const Vector3d step = R_inverse * linear.r.head<3>();
  (landmark.anchor ? landmark.inverse_depth : landmark.p_world) += step;
  auto d_others = s.d_point.take(3, linear.H_others.cols());
  d_others.noalias() = -R_inverse * linear.H_others.topRows<3>();
  for (const int row : s.rows) {
    landmark.clones.push_back({.row = row, .d = d_others.middleCols<6>(column_of(row, s))});
  }
}

// The rows that do not depend on the point.
void keep_null_space(const Linear& linear, double sigma, const MultiViewScratch& s,
                     MultiViewStart& result) {
  result.null_space.clear();
  const Index m = linear.r.size();
  for (Index row = 3; row < m; row += kRowsOfAMeasurement) {
    const Index k = std::min(kRowsOfAMeasurement, m - row);
    Measurement& z = result.null_space.append();
    z.clear();
    z.residual = linear.r.segment(row, k);
    z.d_core.resize(k, 0);
    z.noise = sigma * sigma * MatrixXd::Identity(k, k);
    for (const int other : s.rows) {
      z.clones.push_back(
          {.row = other, .d = linear.H_others.block(row, column_of(other, s), k, 6)});
    }
  }
  result.null_space_rows = static_cast<int>(m - 3);
}

}  // namespace

std::optional<MultiViewStart> initialise_multi_view(std::span<const Camera> cameras,
                                                    const TrackNoise& noise, const State& x,
                                                    LandmarkId id,
                                                    std::span<const ClonedView> views,
                                                    bool anchored, Linearisation at) {
  MultiViewScratch scratch;
  MultiViewStart result;
  if (!initialise_multi_view(cameras, noise, x, id, views, anchored, at, scratch, result)) {
    return std::nullopt;
  }
  return result;
}

bool initialise_multi_view(std::span<const Camera> cameras, const TrackNoise& noise, const State& x,
                           LandmarkId id, std::span<const ClonedView> views, bool anchored,
                           Linearisation at, MultiViewScratch& scratch, MultiViewStart& result) {
  gather_poses(cameras, x, views, scratch);
  const auto point = triangulate(scratch.views);
  if (!point) return false;
  auto linear = linearise(x, views, point->p_world, at, scratch);
  if (!linear) return false;
  whiten(x, views, noise, scratch, *linear);
  find_distance(*linear, *point, noise.sigma, x.clone(views.back().clone).row, scratch, result);
  set_point(id, point->p_world, views, result.landmark);
  if (anchored) hang_on_anchor(x, views.back(), at, scratch, *linear, result.landmark);
  const Matrix3d R = separate(*linear, scratch);
  solve_for_point(*linear, R, noise.sigma, scratch, result.landmark);
  keep_null_space(*linear, noise.sigma, scratch, result);
  result.parallax = point->parallax;
  return true;
}

double relative_depth_sigma(const MultiViewStart& start, const Ekf& filter) {
  const auto P = filter.covariance();
  double variance = start.distance_noise;
  for (const auto& a : start.d_distance) {
    for (const auto& b : start.d_distance) {
      variance += (a.d * P.block<6, 6>(a.row, b.row)).dot(b.d);
    }
  }
  return std::sqrt(std::max(variance, 0.0)) / start.distance;
}

}  // namespace chasles
