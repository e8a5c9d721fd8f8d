#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/calibrate/cameras_report.hpp>
#include <chasles/calibrate/capture_guide.hpp>
#include <chasles/calibrate/correlated_errors_detail.hpp>
#include <chasles/calibrate/target_pose.hpp>

namespace chasles {
namespace {

constexpr double kBlurred = 2;             // [px]
constexpr std::size_t kCornersOfView = 4;  // fewer show no pose
constexpr std::size_t kMostViews = 60;     // of an estimate
constexpr double kMostSigma = 0.1;         // of fx, of a lens that is worth something
constexpr std::size_t kEnoughViews = 20;   // that differ, for a lens that can be estimated at all

std::vector<TargetView> spread(const std::vector<TargetView>& views) {
  const std::size_t count = std::min(kMostViews, views.size());
  std::vector<TargetView> chosen;
  for (std::size_t i = 0; i < count; ++i) {
    chosen.push_back(views[i * views.size() / count]);
    chosen.back().camera = 0;
  }
  return chosen;
}

double rms_over(const std::vector<ExplainedView>& views) {
  double squares = 0, corners = 0;
  for (const ExplainedView& view : views) {
    squares += view.rms * view.rms * static_cast<double>(view.errors.size());
    corners += static_cast<double>(view.errors.size());
  }
  return std::sqrt(squares / std::max(1.0, corners));
}

}  // namespace

void BlurCount::add(double blur) {
  if (std::isnan(blur)) return;
  ++views_;
  if (is_blurred(blur)) ++blurred_;
}

bool BlurCount::is_blurred(double blur) { return blur > kBlurred; }

std::string BlurCount::sentence(std::size_t camera) const {
  if (2 * blurred_ <= views_) return "";
  return fmt::format(
      "cam{}: the edges of {} of {} views are blurred over more than {} px: move more slowly, give "
      "more light, or focus the lens",
      camera, blurred_, views_, kBlurred);
}

LensForm guiding_lens(const Camera& camera, const std::vector<LensForm>& candidates) {
  if (candidates.size() == 1) return candidates.front();
  return camera.fx > 0 ? form_of(camera) : LensForm{Distortion::kEquidistant, 4};
}

CaptureGuide::CaptureGuide(CamerasInput input)
    : input_(std::move(input)),
      coverage_(input_.cameras, input_.corners),
      cameras_(input_.cameras.size()) {
  if (input_.lenses.size() != input_.cameras.size() || input_.cameras.empty()) {
    throw UsageError(
        fmt::format("CaptureGuide: found {} cameras and {} lenses, expected one lens for each "
                    "camera",
                    input_.cameras.size(), input_.lenses.size()));
  }
}

void CaptureGuide::add(const TargetView& view, double blur) {
  check_view(input_, view, "CaptureGuide");
  const auto c = static_cast<std::size_t>(view.camera);
  OfCamera& camera = cameras_[c];
  camera.blur.add(blur);
  if (view.ids.size() < kCornersOfView) return;
  ++camera.views;
  input_.views.push_back(view);
  coverage_.add(view);
  add_pose(view);
  if (!camera.different.empty() && !calibrate_detail::has_moved(camera.different.back(), view)) {
    return;
  }
  camera.different.push_back(view);
  if (camera.different.size() >= camera.next_estimate) improve(c);
}

std::vector<std::string> CaptureGuide::missing() const {
  std::vector<std::string> missing;
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    if (std::string blur = cameras_[c].blur.sentence(c); !blur.empty()) {
      missing.push_back(std::move(blur));
    }
  }
  std::ranges::move(coverage_.missing(), std::back_inserter(missing));
  if (std::string few = few_pieces(pieces()); !few.empty() && !input_.views.empty()) {
    missing.push_back(std::move(few));
  }
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    if (cameras_[c].fault.empty()) continue;
    missing.push_back(
        fmt::format("cam{} has no calibration by these views yet: {}", c, cameras_[c].fault));
  }
  return missing;
}

const std::optional<CaptureGuide::Estimate>& CaptureGuide::estimate(std::size_t camera) const {
  return cameras_[camera].estimate;
}

std::size_t CaptureGuide::views(std::size_t camera) const { return cameras_[camera].views; }

int CaptureGuide::pieces() const {
  if (input_.views.empty()) return 0;
  std::vector<const TargetView*> views;
  for (const TargetView& view : input_.views) views.push_back(&view);
  return calibrate_detail::independent_pieces(calibrate_detail::instants_of(std::move(views)))
             .back() +
         1;
}

void CaptureGuide::add_pose(const TargetView& view) {
  const auto c = static_cast<std::size_t>(view.camera);
  const Camera& lens = cameras_[c].estimate ? cameras_[c].estimate->camera : input_.cameras[c];
  if (lens.fx <= 0) return;
  if (const auto pose = target_pose(lens, input_.corners, view)) {
    coverage_.add_pose(view.camera, pose->cam_T_target);
  }
}

// The lens by the views till now, and their poses by it.
void CaptureGuide::improve(std::size_t camera) {
  OfCamera& own = cameras_[camera];
  own.next_estimate = own.different.size() + (own.different.size() + 1) / 2;
  Camera start = own.estimate ? own.estimate->camera : input_.cameras[camera];
  start.cam_T_imu = {};
  try {
    const CamerasCalibration found = calibrate_cameras({.corners = input_.corners,
                                                        .views = spread(own.different),
                                                        .cameras = {start},
                                                        .lenses = {input_.lenses[camera]},
                                                        .shape = input_.shape});
    const double sigma = std::sqrt(found.covariance(0, 0));
    own.fault.clear();
    if (sigma > kMostSigma * found.cameras[0].fx) return;
    own.estimate = {.camera = found.cameras[0],
                    .focal_length = found.cameras[0].fx,
                    .sigma = sigma,
                    .rms = rms_over(found.views)};
  } catch (const InputError& error) {
    if (own.different.size() >= kEnoughViews) own.fault = error.what();
    return;
  }
  coverage_.clear_poses(static_cast<int>(camera));
  for (const TargetView& view : own.different) add_pose(view);
}

}  // namespace chasles
