#include <algorithm>
#include <numeric>

#include <chasles/calibrate/corner_loss.hpp>
#include <chasles/calibrate/rig_problem_detail.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles::calibrate_detail {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

std::vector<Instant> instants_of(std::vector<const TargetView*> views) {
  std::ranges::stable_sort(views, [](const TargetView* a, const TargetView* b) {
    return std::pair(a->time, a->camera) < std::pair(b->time, b->camera);
  });
  std::vector<Instant> instants;
  for (const TargetView* view : views) {
    if (instants.empty() || instants.back().time != view->time) {
      instants.push_back({view->time, {}});
    }
    instants.back().views.push_back(view);
  }
  return instants;
}

void move(SE3& pose, const Vector6d& d) {
  pose = {so3::normalized(so3::exp(d.head<3>()) * pose.R), pose.p + d.tail<3>()};
}

std::vector<int> columns_from(int first, int count) {
  std::vector<int> columns(static_cast<std::size_t>(count));
  std::iota(columns.begin(), columns.end(), first);
  return columns;
}

std::optional<LinearisedRig> RigProblem::linearised(const RigState& x) const {
  LinearisedRig result{{instants_.size(), 6, layout_.rows()}, 0};
  for (std::size_t k = 0; k < instants_.size(); ++k) {
    for (const TargetView* view : instants_[k].views) {
      if (!add(x, k, *view, result)) return std::nullopt;
    }
  }
  add_priors(x, result);
  return result;
}

void RigProblem::add_priors(const RigState& x, LinearisedRig& result) const {
  for (std::size_t c = 0; c < x.cameras.size(); ++c) {
    for (const LensPrior& prior : lens_priors(layout_.lens(c))) {
      const double value = lens_parameters(x.cameras[c])[prior.parameter];
      const VectorXd r = VectorXd::Constant(1, (value - prior.mean) / prior.sigma);
      const std::vector<int> column = {layout_.lens_row(c) + prior.parameter};
      result.equations.add_border(MatrixXd::Constant(1, 1, 1 / prior.sigma), column, r);
      result.cost += r.squaredNorm() / 2;
    }
  }
  if (corners_.parameters() > 0) {
    const VectorXd inverse = corners_.sigma().cwiseInverse();
    const VectorXd r = x.shape.cwiseProduct(inverse);
    const std::vector<int> columns = columns_from(layout_.shape_row(), layout_.shape_rows());
    result.equations.add_border(MatrixXd(inverse.asDiagonal()), columns, r);
    result.cost += r.squaredNorm() / 2;
  }
}

std::optional<RigState> RigProblem::moved(const RigState& x,
                                          const ChainEquations::Step& step) const {
  RigState next = x;
  for (std::size_t c = 0; c < x.cameras.size(); ++c) {
    const VectorXd lens = step.border.segment(layout_.lens_row(c), layout_.lens(c).parameters());
    const auto camera = chasles::moved(x.cameras[c], lens);
    if (!camera) return std::nullopt;
    next.cameras[c] = *camera;
    if (c == 0) continue;
    move(next.cameras[c].cam_T_imu, step.border.segment<6>(layout_.pose_row(c)));
  }
  next.shape += step.border.tail(corners_.parameters());
  for (std::size_t k = 0; k < instants_.size(); ++k) move(next.cam0_T_target[k], step.blocks[k]);
  return next;
}

bool RigProblem::add(const RigState& x, std::size_t instant, const TargetView& view,
                     LinearisedRig& result) const {
  const auto c = static_cast<std::size_t>(view.camera);
  const Camera& camera = x.cameras[c];
  const SE3& cam_T_cam0 = camera.cam_T_imu;
  const SE3& cam0_T_target = x.cam0_T_target[instant];
  const int lens = layout_.lens(c).parameters(), pose = c > 0 ? 6 : 0;
  const int shape = layout_.shape_rows(), border = lens + pose + shape;
  const MatrixXd by_coordinates = by_search_coordinates(
      layout_.lens(c), search_coordinates(layout_.lens(c), lens_parameters(camera)));
  const auto rows = 2 * static_cast<Eigen::Index>(view.ids.size());
  MatrixXd by_pose(rows, 6), by_border(rows, border);
  VectorXd r(rows);
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    const Vector3d arm = cam0_T_target.R * corners_.at(view.ids[i], x.shape);
    const Vector3d turned = cam_T_cam0.R * (arm + cam0_T_target.p);
    const Vector3d p_cam = turned + cam_T_cam0.p;
    const auto image = project(camera, p_cam);
    if (!image) return false;
    const auto row = 2 * static_cast<Eigen::Index>(i);
    const Vector2d error = (image->pixel - view.pixels[i]) / sigma_;
    const WeightedCorner w = weighted_corner(error.norm());
    const double factor = w.root_weight / sigma_;
    const Eigen::Matrix<double, 2, 3> by_cam0 = factor * image->d_point * cam_T_cam0.R;
    by_pose.block<2, 3>(row, 0) = -by_cam0 * hat(arm);
    by_pose.block<2, 3>(row, 3) = by_cam0;
    by_border.block(row, 0, 2, lens) =
        factor * *parameter_derivative(camera, p_cam) * by_coordinates;
    if (c > 0) {
      by_border.block<2, 3>(row, lens) = -factor * image->d_point * hat(turned);
      by_border.block<2, 3>(row, lens + 3) = factor * image->d_point;
    }
    if (shape > 0) {
      by_border.block(row, lens + pose, 2, shape) =
          by_cam0 * cam0_T_target.R * corners_.by_parameters(view.ids[i]);
    }
    r.segment<2>(row) = w.root_weight * error;
    result.cost += w.cost;
  }
  std::vector<int> columns = columns_from(layout_.lens_row(c), lens + pose);
  for (int i = 0; i < shape; ++i) columns.push_back(layout_.shape_row() + i);
  result.equations.add(instant, by_pose, by_border, columns, r);
  return true;
}

}  // namespace chasles::calibrate_detail
