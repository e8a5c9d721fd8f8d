#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/camera_alone_detail.hpp>
#include <chasles/calibrate/camera_guess.hpp>
#include <chasles/calibrate/rig_search_detail.hpp>
#include <chasles/calibrate/target_pose.hpp>

namespace chasles::calibrate_detail {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Views of one camera with a pose.
std::vector<PosedView> posed(const Camera& camera, const std::vector<Vector3d>& corners,
                             const std::vector<const TargetView*>& views) {
  std::vector<PosedView> result;
  for (const TargetView* view : views) {
    if (const auto pose = target_pose(camera, corners, *view, kFirstLossWidth)) {
      result.push_back({view, pose->cam_T_target});
    }
  }
  return result;
}

std::vector<PixelDirection> directions_of(const Camera& camera,
                                          const std::vector<PosedView>& views) {
  std::vector<PixelDirection> directions;
  for (const PosedView& posed : views) {
    for (const Vector2d& pixel : posed.view->pixels) {
      if (const auto direction = bearing(camera, pixel)) {
        directions.push_back({direction->bearing, pixel});
      }
    }
  }
  constexpr std::size_t kEnough = 2000;
  if (directions.size() <= kEnough) return directions;
  std::vector<PixelDirection> some;
  for (std::size_t i = 0; i < kEnough; ++i) {
    some.push_back(directions[i * directions.size() / kEnough]);
  }
  return some;
}

std::vector<const TargetView*> pointers(const std::vector<PosedView>& views) {
  std::vector<const TargetView*> result;
  for (const PosedView& one : views) result.push_back(one.view);
  return result;
}

Solved searched_alone(Camera camera, const LensForm& lens, const std::vector<Vector3d>& corners,
                      const std::vector<const TargetView*>& views, const std::string& of,
                      const SearchLimits& limits) {
  camera.cam_T_imu = {};
  const std::vector<PosedView> inside = posed(camera, corners, views);
  if (inside.size() < kLeastViews) {
    throw InputError(fmt::format(
        "{}: found {} views that have a pose with a lens {}, expected {}: is it this target?", of,
        inside.size(), name_of(lens), kLeastViews));
  }
  const CamerasLayout layout({lens});
  std::vector<TargetView> own;
  for (const PosedView& one : inside) {
    own.push_back(*one.view);
    own.back().camera = 0;
  }
  std::vector<const TargetView*> of_problem;
  for (const TargetView& view : own) of_problem.push_back(&view);
  const TargetShape drawn;  // the rig knows more of another one
  const ShapedCorners of_target(corners, drawn);
  RigProblem problem(of_target, instants_of(of_problem), layout);
  RigState state{.cameras = {camera}, .cam0_T_target = {}};
  for (const Instant& instant : problem.instants()) {
    const auto index = static_cast<std::size_t>(instant.views[0] - own.data());
    state.cam0_T_target.push_back(inside[index].cam_T_target);
  }
  return solved(problem, layout, std::move(state), of, limits);
}

AloneCamera calibrated_from(const Camera& first, const LensForm& lens,
                            const std::vector<Vector3d>& corners,
                            const std::vector<const TargetView*>& views, const std::string& of,
                            const SearchLimits& limits) {
  std::vector<PosedView> usable = posed(first, corners, views);
  if (usable.size() < kLeastViews) {
    throw InputError(fmt::format(
        "{}: found {} views of the target that have a pose, expected {}: is it this target?", of,
        usable.size(), kLeastViews));
  }
  const std::vector<Camera> starts = fitted_lenses(first, lens, directions_of(first, usable));
  std::optional<Solved> best;
  std::optional<InputError> fault;
  for (const Camera& start : starts) {
    try {
      Solved one = searched_alone(start, lens, corners, pointers(usable), of, limits);
      if (!best || one.squares < best->squares) best = std::move(one);
    } catch (const InputError& error) {
      fault = error;
    }
  }
  if (!best && fault) throw *fault;
  if (!best) throw InputError(fmt::format("{}: no lens {} has these corners", of, name_of(lens)));
  const Camera& found = best->state.cameras[0];
  return {found, posed(found, corners, views)};
}

}  // namespace

AloneCamera calibrated_alone(const Camera& first, const LensForm& lens,
                             const std::vector<Vector3d>& corners,
                             const std::vector<const TargetView*>& views, const std::string& of,
                             const SearchLimits& limits) {
  if (views.size() < kLeastViews) {
    throw InputError(
        fmt::format("{}: found {} views of the target with {} corners or more, "
                    "expected {}",
                    of, views.size(), kLeastCorners, kLeastViews));
  }
  if (first.fx > 0) {
    try {
      return calibrated_from(first, lens, corners, views, of, limits);
    } catch (const InputError&) {
      // A lens that is far off is worse than none.
    }
  }
  const std::optional<Camera> guess = guessed_camera(first, corners, views);
  if (!guess) {
    throw InputError(
        fmt::format("{}: no lens explains the corners: is it this target, and are its "
                    "sizes right?",
                    of));
  }
  return calibrated_from(*guess, lens, corners, views, of, limits);
}

}  // namespace chasles::calibrate_detail
