#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/camera_alone_detail.hpp>
#include <chasles/calibrate/cameras_calibration.hpp>
#include <chasles/calibrate/correlated_errors_detail.hpp>
#include <chasles/calibrate/frame_lag.hpp>
#include <chasles/calibrate/rig_search_detail.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

using calibrate_detail::AloneCamera;
using calibrate_detail::calibrated_alone;
using calibrate_detail::columns_from;
using calibrate_detail::correlation_factor;
using calibrate_detail::independent_pieces;
using calibrate_detail::Instant;
using calibrate_detail::instants_of;
using calibrate_detail::kLeastCorners;
using calibrate_detail::kLeastViews;
using calibrate_detail::LinearisedRig;
using calibrate_detail::PosedView;
using calibrate_detail::RigProblem;
using calibrate_detail::RigState;
using calibrate_detail::Solved;
using calibrate_detail::solved;

std::vector<const TargetView*> of_camera(const std::vector<const TargetView*>& views, int camera) {
  std::vector<const TargetView*> result;
  std::ranges::copy_if(views, std::back_inserter(result),
                       [&](const TargetView* view) { return view->camera == camera; });
  return result;
}

std::string said(int camera) { return fmt::format("cam{}", camera); }

double distance(const SE3& a, const SE3& b) {
  return so3::log(a.R * b.R.transpose()).norm() + (a.p - b.p).norm();
}

// Of several poses, that which is nearest to the others.
SE3 middle_pose(const std::vector<SE3>& poses) {
  constexpr std::size_t kMost = 60;
  std::vector<SE3> some;
  const std::size_t count = std::min(kMost, poses.size());
  for (std::size_t i = 0; i < count; ++i) some.push_back(poses[i * poses.size() / count]);
  const auto sum = [&](const SE3& pose) {
    double all = 0;
    for (const SE3& other : some) all += distance(pose, other);
    return all;
  };
  return *std::ranges::min_element(some, {}, sum);
}

// cam_T_cam0 of all cameras, through those that see the target at the same instants.
void place_cameras(std::vector<AloneCamera>& cameras) {
  std::vector<std::map<Time, SE3>> poses(cameras.size());
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    for (const PosedView& one : cameras[c].views) poses[c][one.view->time] = one.cam_T_target;
  }
  std::vector<bool> placed(cameras.size(), false);
  placed[0] = true;
  cameras[0].camera.cam_T_imu = {};
  for (std::size_t round = 1; round < cameras.size(); ++round) {
    std::size_t next = 0;
    std::vector<SE3> best;
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      for (std::size_t from = 0; !placed[c] && from < cameras.size(); ++from) {
        if (!placed[from]) continue;
        std::vector<SE3> relative;
        for (const auto& [time, pose] : poses[c]) {
          const auto other = poses[from].find(time);
          if (other == poses[from].end()) continue;
          relative.push_back(pose * other->second.inverse() * cameras[from].camera.cam_T_imu);
        }
        if (relative.size() > best.size()) best = relative, next = c;
      }
    }
    if (best.size() < kLeastViews) {
      std::string alone;
      for (std::size_t c = 0; c < cameras.size(); ++c) {
        if (!placed[c]) alone += (alone.empty() ? "" : ", ") + said(static_cast<int>(c));
      }
      throw InputError(fmt::format(
          "{}: found {} instants at which it and another camera see the target, expected {}: "
          "show the target to two cameras at a time, or calibrate each camera alone",
          alone, best.size(), kLeastViews));
    }
    cameras[next].camera.cam_T_imu = middle_pose(best);
    placed[next] = true;
  }
}

// The cameras of an instant see one pose of the target.
void check_lags(const std::vector<AloneCamera>& cameras) {
  std::vector<std::map<Time, SE3>> poses(cameras.size());
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    for (const PosedView& one : cameras[c].views) poses[c][one.view->time] = one.cam_T_target;
    for (std::size_t other = 0; other < c; ++other) {
      const std::optional<FrameLag> lag = frame_lag(poses[other], poses[c]);
      if (!lag) continue;
      const int frames = std::abs(lag->frames);
      throw InputError(fmt::format(
          "cam{} is {} frame{} ({:.3f} s) late against cam{}: the target moves in its images as in "
          "those that came before; expected images of an instant to have one time: is an image "
          "lost, or are the stamps of one camera those of its transfer?",
          lag->frames > 0 ? c : other, frames, frames > 1 ? "s" : "", lag->seconds,
          lag->frames > 0 ? other : c));
    }
  }
}

RigState rig_state(const std::vector<AloneCamera>& cameras, const std::vector<Instant>& instants) {
  std::map<const TargetView*, SE3> poses;
  for (const AloneCamera& camera : cameras) {
    for (const PosedView& one : camera.views) poses[one.view] = one.cam_T_target;
  }
  RigState state;
  for (const AloneCamera& camera : cameras) state.cameras.push_back(camera.camera);
  for (const Instant& instant : instants) {
    const TargetView& view = **std::ranges::max_element(
        instant.views, {}, [](const TargetView* one) { return one->ids.size(); });
    state.cam0_T_target.push_back(
        state.cameras[static_cast<std::size_t>(view.camera)].cam_T_imu.inverse() * poses.at(&view));
  }
  return state;
}

ExplainedView explained(const RigState& x, std::size_t instant, const TargetView& view,
                        const ShapedCorners& corners) {
  const Camera& camera = x.cameras[static_cast<std::size_t>(view.camera)];
  ExplainedView result{.view = view,
                       .cam_T_target = camera.cam_T_imu * x.cam0_T_target[instant],
                       .errors = {},
                       .rms = 0};
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    const auto image = project(camera, result.cam_T_target * corners.at(view.ids[i], x.shape));
    result.errors.push_back(view.pixels[i] - image->pixel);
    result.rms += result.errors.back().squaredNorm();
  }
  result.rms = std::sqrt(result.rms / static_cast<double>(view.ids.size()));
  return result;
}

void check_input(const CamerasInput& input) {
  if (input.cameras.empty() || input.cameras.size() != input.lenses.size()) {
    throw UsageError(
        fmt::format("calibrate_cameras: found {} cameras and {} lenses, expected one "
                    "lens for each camera",
                    input.cameras.size(), input.lenses.size()));
  }
  for (const TargetView& view : input.views) check_view(input, view, "calibrate_cameras");
}

}  // namespace

CamerasLayout::CamerasLayout(const std::vector<LensForm>& lenses,
                             std::vector<std::string> shape_names)
    : lenses_(lenses), shape_names_(std::move(shape_names)) {
  int row = 0;
  for (std::size_t c = 0; c < lenses.size(); ++c) {
    first_.push_back(row);
    row += lenses[c].parameters() + (c > 0 ? 6 : 0);
  }
  first_.push_back(row);
}

std::vector<std::string> CamerasLayout::names() const {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < lenses_.size(); ++c) {
    const std::string of = said(static_cast<int>(c)) + ".";
    for (const std::string& name : lens_parameter_names(lenses_[c])) names.push_back(of + name);
    if (c == 0) continue;
    for (const char* part : {"rotation", "position"}) {
      for (const char* axis : {"_x", "_y", "_z"}) names.push_back(of + part + axis);
    }
  }
  for (const std::string& name : shape_names_) names.push_back("target." + name);
  return names;
}

void check_view(const CamerasInput& input, const TargetView& view, const std::string& caller) {
  const auto is_corner = [&](int id) {
    return id >= 0 && static_cast<std::size_t>(id) < input.corners.size();
  };
  if (view.camera < 0 || static_cast<std::size_t>(view.camera) >= input.cameras.size() ||
      view.ids.size() != view.pixels.size() || !std::ranges::all_of(view.ids, is_corner)) {
    throw UsageError(
        fmt::format("{}: a view of camera {} with {} ids and {} pixels: expected a camera "
                    "below {}, and a pixel for each id, from 0 to {}",
                    caller, view.camera, view.ids.size(), view.pixels.size(), input.cameras.size(),
                    input.corners.size() - 1));
  }
  const Camera& size = input.cameras[static_cast<std::size_t>(view.camera)];
  const auto is_outside = [&](const Vector2d& p) {
    return p.allFinite() && (p.x() < -1 || p.y() < -1 || p.x() > size.width || p.y() > size.height);
  };
  if (const auto out = std::ranges::find_if(view.pixels, is_outside); out != view.pixels.end()) {
    throw InputError(fmt::format(
        "cam{}: found a corner at ({:.6g}, {:.6g}) px, expected it in the image of {} x {}",
        view.camera, out->x(), out->y(), size.width, size.height));
  }
  if (!std::ranges::all_of(view.pixels, [](const Vector2d& p) { return p.allFinite(); })) {
    throw UsageError(
        fmt::format("{}: a view of camera {} has a pixel that is not finite", caller, view.camera));
  }
}

CamerasCalibration calibrate_cameras(const CamerasInput& input) {
  check_input(input);
  std::vector<const TargetView*> views;
  for (const TargetView& view : input.views) {
    if (view.ids.size() >= kLeastCorners) views.push_back(&view);
  }
  std::vector<AloneCamera> cameras;
  std::vector<const TargetView*> usable;
  for (std::size_t c = 0; c < input.cameras.size(); ++c) {
    const int camera = static_cast<int>(c);
    cameras.push_back(calibrated_alone(input.cameras[c], input.lenses[c], input.corners,
                                       of_camera(views, camera), said(camera)));
    for (const PosedView& one : cameras.back().views) usable.push_back(one.view);
  }
  check_lags(cameras);
  place_cameras(cameras);
  const CamerasLayout layout(input.lenses, input.shape.names);
  const ShapedCorners corners(input.corners, input.shape);
  RigProblem problem(corners, instants_of(usable), layout);
  RigState start = rig_state(cameras, problem.instants());
  start.shape = VectorXd::Zero(corners.parameters());
  const Solved found = solved(problem, layout, std::move(start), "the cameras");
  const std::optional<LinearisedRig> linearised = problem.linearised(found.state);
  const ChainEquations& equations = linearised->equations;
  const std::optional<MatrixXd> information = equations.border_information();
  const Eigen::LLT<MatrixXd> factor(information.value_or(MatrixXd::Zero(1, 1)));
  if (!information || factor.info() != Eigen::Success) {
    throw UndeterminedError("the cameras: the views do not determine all parameters");
  }
  CamerasCalibration result{
      .cameras = found.state.cameras,
      .lenses = input.lenses,
      .shape_names = input.shape.names,
      .shape = found.state.shape,
      .covariance = factor.solve(MatrixXd::Identity(layout.rows(), layout.rows())),
      .pixel_sigma = found.sigma,
      .pieces = 0,
      .correlation_factor = 1,
      .views = {},
      .without_pose = input.views.size() - usable.size(),
      .iterations = found.iterations};
  const std::vector<int> pieces = independent_pieces(problem.instants());
  result.pieces = pieces.back() + 1;
  if (const std::optional<MatrixXd> gradients = equations.border_gradients()) {
    result.correlation_factor =
        correlation_factor(*information, *gradients, columns_from(0, layout.rows()), pieces);
  }
  result.covariance *= result.correlation_factor;
  MatrixXd by_coordinates = MatrixXd::Identity(layout.rows(), layout.rows());
  for (std::size_t c = 0; c < result.cameras.size(); ++c) {
    const LensForm& lens = layout.lens(c);
    const int row = layout.lens_row(c), n = lens.parameters();
    by_coordinates.block(row, row, n, n) =
        by_search_coordinates(lens, search_coordinates(lens, lens_parameters(result.cameras[c])));
  }
  result.covariance = by_coordinates * result.covariance * by_coordinates.transpose();
  for (std::size_t k = 0; k < problem.instants().size(); ++k) {
    for (const TargetView* view : problem.instants()[k].views) {
      result.views.push_back(explained(found.state, k, *view, corners));
    }
  }
  return result;
}

}  // namespace chasles
