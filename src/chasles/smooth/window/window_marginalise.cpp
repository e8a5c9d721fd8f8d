#include <algorithm>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <chasles/filter/dense.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/smooth/window/window_detail.hpp>

// Marginalisation of a window's oldest keyframe into the prior.
namespace chasles::smooth_detail {
namespace {

bool sees(const WindowPoint& point, int keyframe) {
  return std::ranges::any_of(point.views,
                             [&](const WindowView& v) { return v.keyframe == keyframe; });
}

bool hangs_before(const Window& window, const WindowPoint& point, int keyframe) {
  return (window.anchored && point.anchor < keyframe) ||
         (!point.views.empty() && point.views.front().keyframe < keyframe);
}

// An anchored landmark in the same axes of another keyframe, and the derivatives of the new
// parameters by both poses, the extrinsics and the old ones.
struct Moved {
  Eigen::Vector3d parameters;
  Eigen::Matrix<double, 3, 6> by_old, by_new;
  std::optional<Eigen::Matrix<double, 3, 6>> by_camera;  // extrinsics, if the axes move with them
  Eigen::Matrix3d by_parameters;
};

std::optional<Moved> moved_to(const Window& window, const WindowPoint& point, int keyframe) {
  const Clone anchor = clone_of(window, point.anchor);
  const SE3 world_T_imu = clone_of(window, keyframe).world_T_imu;
  const HomogeneousPoint at = homogeneous(anchor, landmark_of(point));
  const Eigen::Matrix3d cam_R_world = point.cam_T_imu.R * world_T_imu.R.transpose();
  const Eigen::Vector3d from_imu = at.p_world - at.w * world_T_imu.p;
  const Eigen::Vector3d q = cam_R_world * from_imu + at.w * point.cam_T_imu.p;
  if (!is_ahead(q)) return std::nullopt;  // these axes do not suit it any longer
  Moved moved;
  moved.parameters = Eigen::Vector3d(q.x(), q.y(), at.w) / q.z();
  // By q, and by w, which is the last of the old parameters.
  Eigen::Matrix3d by_q = Eigen::Matrix3d::Zero();
  by_q.topLeftCorner<2, 2>().setIdentity();
  by_q.col(2) = -moved.parameters;
  by_q /= q.z();
  const Eigen::Matrix<double, 3, 9> q_by_old =
      cam_R_world * homogeneous_derivative(anchor, landmark_of(point));
  moved.by_old = by_q * q_by_old.leftCols<6>();
  moved.by_parameters = by_q * q_by_old.rightCols<3>();
  const Eigen::Vector3d q_by_w = point.cam_T_imu.p - cam_R_world * world_T_imu.p;
  moved.by_parameters.col(2) += by_q * q_by_w + Eigen::Vector3d(0, 0, 1 / q.z());
  moved.by_new << by_q * cam_R_world * hat(from_imu), -at.w * by_q * cam_R_world;
  if (point.camera) {
    // The old axes move the point; the new ones move about it.
    Landmark there = landmark_of(point);
    there.inverse_depth = moved.parameters;
    const Clone to{.world_T_imu = world_T_imu};
    moved.by_camera = by_q * cam_R_world *
                      (homogeneous_derivative_by_camera(anchor, landmark_of(point)) -
                       q.z() * homogeneous_derivative_by_camera(to, there));
  }
  return moved;
}

// The system by the new parameters of a landmark instead of the old ones; uses all of S.
// `extrinsics`: the row of them.
void substitute(const Moved& moved, int row, int old_anchor, int new_anchor, int extrinsics,
                WindowSystem& system) {
  const Eigen::Matrix3d old_by_new = moved.by_parameters.inverse();
  const Eigen::Matrix<double, 3, 6> by_old = -old_by_new * moved.by_old;
  const Eigen::Matrix<double, 3, 6> by_new = -old_by_new * moved.by_new;
  Eigen::MatrixXd& S = system.S;
  const Eigen::MatrixXd columns = S.middleCols<3>(row);
  S.middleCols<6>(old_anchor) += columns * by_old;
  S.middleCols<6>(new_anchor) += columns * by_new;
  S.middleCols<3>(row) = columns * old_by_new;
  if (moved.by_camera) S.middleCols<6>(extrinsics) -= columns * (old_by_new * *moved.by_camera);
  const Eigen::MatrixXd lines = S.middleRows<3>(row);
  S.middleRows<6>(old_anchor) += by_old.transpose() * lines;
  S.middleRows<6>(new_anchor) += by_new.transpose() * lines;
  S.middleRows<3>(row) = old_by_new.transpose() * lines;
  if (moved.by_camera) {
    S.middleRows<6>(extrinsics) -= (old_by_new * *moved.by_camera).transpose() * lines;
  }
  const Eigen::Vector3d g = system.g.segment<3>(row);
  system.g.segment<6>(old_anchor) += by_old.transpose() * g;
  system.g.segment<6>(new_anchor) += by_new.transpose() * g;
  system.g.segment<3>(row) = old_by_new.transpose() * g;
  if (moved.by_camera) {
    system.g.segment<6>(extrinsics) -= (old_by_new * *moved.by_camera).transpose() * g;
  }
}

// Moves the anchors of the remaining landmarks to the newest keyframe; uses all of S.
void hang_on_newest(const WindowRows& rows, Window& window, WindowSystem& system) {
  for (auto& [number, point] : window.points) {
    if (!window.anchored || point.anchor != window.first || !rows.points.contains(number)) continue;
    const auto moved = moved_to(window, point, window.last());
    if (!moved || !sees(point, window.last())) continue;  // its track ends
    const int row = rows.points.at(number);
    if (point.alone) {
      WindowPoint bare{.parameters = point.parameters, .alone = std::move(point.alone)};
      const PointLinear alone = linearise(window, bare);
      system.S.block<3, 3>(row, row) += alone.V;
      system.g.segment<3>(row) += alone.b;
    }
    const int extrinsics = point.camera ? rows.calibration + extrinsics_row(window, point) : 0;
    substitute(*moved, row, rows.keyframe(window.first), rows.keyframe(window.last()), extrinsics,
               system);
    point.anchor = window.last();
    point.parameters = moved->parameters;
    point.stale = true;
  }
}

// The linearised terms of the oldest keyframe; lower triangle.
void absorb(Window& window, const WindowRows& rows, const std::vector<int>& ending,
            WindowSystem& system) {
  for (auto& [number, point] : window.points) {
    const auto row = rows.points.find(number);
    const auto own = row != rows.points.end() ? std::optional(row->second) : std::nullopt;
    if (std::ranges::binary_search(ending, number)) {
      add_point(rows, point.linear, own, point.linear.V_inverse, system);
    } else if (sees(point, window.first)) {
      const PointLinear linear = linearise(window, point, window.first);
      add_point(rows, linear, own, linear.V_inverse, system);
    }
  }
  for (const ChainTerm& term : window.terms) {
    if (term.first == window.first && term.keyframes == 1) add_term(rows, term, system);
  }
}

// Reads all of S and writes the lower triangle. The landmarks are eliminated one by one, but one
// product for all takes a fraction of the time.
void eliminate_points(const WindowRows& rows, const std::vector<int>& ending,
                      WindowSystem& system) {
  std::vector<int> gone;
  for (const int number : ending) {
    if (rows.points.contains(number)) gone.push_back(rows.points.at(number));
  }
  const Eigen::Index n = rows.size, width = 3 * std::ssize(gone);
  Eigen::MatrixXd columns(n, width), informed(n, width);  // informed columns^T is subtracted
  Eigen::Index done = 0;
  for (const int row : gone) {
    auto own = columns.middleCols<3>(done);
    own = system.S.middleCols<3>(row);
    own.noalias() -= informed.leftCols(done) * columns.block(row, 0, 3, done).transpose();
    informed.middleCols<3>(done).noalias() = own * inverse_on_range(own.middleRows<3>(row));
    const Eigen::Vector3d g = system.g.segment<3>(row);
    system.g.noalias() -= informed.middleCols<3>(done) * g;
    done += 3;
  }
  dense::add_product_lower(-informed, columns.transpose(), system.S);
}

// Eliminates a keyframe in the coordinates of its link: the keyframe's errors are replaced by the
// link's whitened residual d. The link's information is then 1, whatever its weight, and the
// information on the keyframe is not lost in the difference of large numbers (prediction of an
// information filter). Reads all of S and writes the lower triangle.
void eliminate_keyframe(const ChainTerm& link, const WindowRows& rows, WindowSystem& system) {
  Eigen::MatrixXd& S = system.S;
  const int n = rows.errors, row = rows.keyframe(rows.first), next = row + n;
  const Eigen::MatrixXd M = small::inverse(link.jacobian.leftCols(n));
  const Eigen::MatrixXd K = M * link.jacobian.middleCols(n, n);
  const int c = rows.calibration + (link.calibration ? link.calibration->row : 0);
  const int m = link.calibration ? link.calibration->errors : 0;
  const Eigen::MatrixXd by_calibration = M * link.jacobian.rightCols(m);
  const Eigen::MatrixXd columns = S.middleCols(row, n);
  system.g.noalias() -= columns * (M * link.residual);
  S.middleCols(next, n).noalias() -= columns * K;
  S.middleCols(c, m).noalias() -= columns * by_calibration;
  S.middleCols(row, n).noalias() = columns * M;
  const Eigen::MatrixXd lines = S.middleRows(row, n);
  S.middleRows(next, n).noalias() -= K.transpose() * lines;
  S.middleRows(c, m).noalias() -= by_calibration.transpose() * lines;
  S.middleRows(row, n).noalias() = M.transpose() * lines;
  const Eigen::VectorXd g = system.g.segment(row, n);
  system.g.segment(next, n).noalias() -= K.transpose() * g;
  system.g.segment(c, m).noalias() -= by_calibration.transpose() * g;
  system.g.segment(row, n).noalias() = M.transpose() * g;
  S.block(row, row, n, n).diagonal().array() += 1;
  // L^-1 of the blocks that couple d with the rest, S_dd = L L^T.
  const Eigen::LLT<Eigen::MatrixXd> cholesky(S.block(row, row, n, n));
  const Eigen::MatrixXd by_d = cholesky.matrixL().solve(S.middleRows(row, n)).transpose();
  system.g.noalias() -= by_d * cholesky.matrixL().solve(system.g.segment(row, n));
  dense::downdate_lower(by_d, S);
}

const ChainTerm& first_link(const Window& window) {
  return *std::ranges::find_if(window.terms, [&](const ChainTerm& term) {
    return term.first == window.first && term.keyframes == 2;
  });
}

void drop_oldest(const std::vector<int>& ending, Window& window) {
  window.points.erase(ending);
  for (auto& [number, point] : window.points) {
    const auto of_oldest = [&](const WindowView& v) { return v.keyframe == window.first; };
    if (std::erase_if(point.views, of_oldest) > 0) point.stale = true;
  }
  std::erase_if(window.terms, [&](const ChainTerm& t) { return t.first == window.first; });
  window.keyframes.pop_front();
  ++window.first;
}

}  // namespace

std::vector<int> ending_points(const Window& window, int keyframe) {
  std::vector<int> ending;
  for (const auto& [number, point] : window.points) {
    const bool moves = window.anchored && point.anchor <= keyframe;
    const bool stays = sees(point, window.last()) &&
                       (!moves || moved_to(window, point, window.last()).has_value());
    if ((hangs_before(window, point, keyframe + 1) || point.views.empty()) && !stays) {
      ending.push_back(number);
    }
  }
  return ending;
}

void marginalise_oldest(Window& window) {
  const std::vector<int> ending = ending_points(window, window.first);
  std::vector<int> joining;
  for (const auto& [number, point] : window.points) {
    if (!point.in_prior && hangs_before(window, point, window.first + 1) &&
        !std::ranges::binary_search(ending, number)) {
      joining.push_back(number);
    }
  }
  const WindowSystem prior = prior_system(window);
  const WindowRows before = prior_rows(window);
  for (const int number : joining) window.points.at(number).in_prior = true;
  const WindowRows rows(window, window.count(), 2);
  WindowSystem system = in_rows(prior, before, rows);
  dense::mirror_lower(system.S);
  hang_on_newest(rows, window, system);
  absorb(window, rows, ending, system);
  dense::mirror_lower(system.S);
  eliminate_points(rows, ending, system);
  dense::mirror_lower(system.S);
  eliminate_keyframe(first_link(window), rows, system);
  drop_oldest(ending, window);
  set_prior(window, in_rows(system, rows, WindowRows(window, window.count(), 1)));
}

}  // namespace chasles::smooth_detail
