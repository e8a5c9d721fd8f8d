#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/camera_guess.hpp>
#include <chasles/calibrate/cross_validation.hpp>
#include <chasles/calibrate/projection_uncertainty.hpp>
#include <chasles/calibrate/target_pose.hpp>

namespace chasles {
namespace {

constexpr int kPieces = 10;      // of which the halves take turns
constexpr double kMissing = 10;  // error of a corner that has no pixel [px]
constexpr double kAlike = 1.01;  // ratio of errors

std::vector<CamerasInput> halves_of(const CamerasInput& input) {
  std::vector<CamerasInput> halves(2, input);
  halves[0].views.clear();
  halves[1].views.clear();
  std::vector<Time> times;
  for (const TargetView& view : input.views) times.push_back(view.time);
  std::ranges::sort(times);
  times.erase(std::unique(times.begin(), times.end()), times.end());
  for (const TargetView& view : input.views) {
    const auto index = std::ranges::lower_bound(times, view.time) - times.begin();
    const auto piece = kPieces * index / static_cast<std::ptrdiff_t>(times.size());
    halves[static_cast<std::size_t>(piece % 2)].views.push_back(view);
  }
  return halves;
}

struct Squares {
  double sum = 0, corners = 0;
  double rms() const { return std::sqrt(sum / std::max(1.0, corners)); }
};

// Of views that took no part in the calibration. Each camera's views have poses of their own.
void add_held_out(const std::vector<Camera>& cameras, const CamerasInput& views, Squares& squares) {
  for (const TargetView& view : views.views) {
    if (view.ids.size() < 4) continue;
    const auto pose =
        target_pose(cameras[static_cast<std::size_t>(view.camera)], views.corners, view, 1);
    const auto corners = static_cast<double>(view.ids.size());
    const double rms = pose ? std::min(pose->rms, kMissing) : kMissing;
    squares.sum += corners * rms * rms;
    squares.corners += corners;
  }
}

double rms_of(const std::vector<PixelDifference>& differences) {
  double sum = 0;
  for (const PixelDifference& one : differences) sum += one.difference.squaredNorm() / 2;
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, differences.size())));
}

double rms_sigma(const CamerasCalibration& calibration, std::size_t camera) {
  const auto grid =
      projection_uncertainty(calibration.cameras[camera], lens_covariance(calibration, camera));
  double sum = 0;
  for (const PixelUncertainty& one : grid) sum += one.sigma_px * one.sigma_px;
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, grid.size())));
}

Eigen::VectorXd differences(const CamerasCalibration& a, const CamerasCalibration& b) {
  const CamerasLayout layout = a.layout();
  const std::vector<LensForm>& lenses = a.lenses;
  Eigen::VectorXd result(layout.rows());
  result.tail(layout.shape_rows()) = b.shape - a.shape;
  for (std::size_t c = 0; c < lenses.size(); ++c) {
    result.segment(layout.lens_row(c), lenses[c].parameters()) =
        lens_parameters(b.cameras[c]) - lens_parameters(a.cameras[c]);
    if (c == 0) continue;
    const SE3 &from = a.cameras[c].cam_T_imu, &to = b.cameras[c].cam_T_imu;
    result.segment<3>(layout.pose_row(c)) = so3::log(to.R * from.R.transpose());
    result.segment<3>(layout.pose_row(c) + 3) = to.p - from.p;
  }
  return result;
}

// Evenly over the recording: more say little about which lens it is.
std::vector<TargetView> some_of(const std::vector<TargetView>& views) {
  constexpr std::size_t kEnough = 240;
  if (views.size() <= kEnough) return views;
  std::vector<TargetView> some;
  for (std::size_t i = 0; i < kEnough; ++i) some.push_back(views[i * views.size() / kEnough]);
  return some;
}

// The one of fewest parameters among those that predict nearly as well as the best; null: none has
// a calibration.
LensTrial* preferred(std::vector<LensTrial>& trials) {
  double least = std::numeric_limits<double>::infinity();
  for (const LensTrial& trial : trials) least = std::fmin(least, trial.held_out_rms);
  LensTrial* best = nullptr;
  for (LensTrial& trial : trials) {
    if (!(trial.held_out_rms <= kAlike * least)) continue;
    if (best == nullptr || trial.lens.parameters() < best->lens.parameters()) best = &trial;
  }
  return best;
}

}  // namespace

HalvesComparison compare_halves(const CamerasInput& input) {
  const std::vector<CamerasInput> halves = halves_of(input);
  const CamerasCalibration a = calibrate_cameras(halves[0]), b = calibrate_cameras(halves[1]);
  HalvesComparison result{.difference = differences(a, b),
                          .sigma = (a.covariance + b.covariance).diagonal().cwiseSqrt(),
                          .pixels = {},
                          .pixels_sigma = {},
                          .held_out_rms = 0};
  for (std::size_t c = 0; c < a.cameras.size(); ++c) {
    result.pixels.push_back(rms_of(projection_difference(a.cameras[c], b.cameras[c])));
    result.pixels_sigma.push_back(std::hypot(rms_sigma(a, c), rms_sigma(b, c)));
  }
  Squares squares;
  add_held_out(a.cameras, halves[1], squares);
  add_held_out(b.cameras, halves[0], squares);
  result.held_out_rms = squares.rms();
  return result;
}

LensChoice choose_lens(const CamerasInput& input, std::size_t camera,
                       const std::vector<LensForm>& candidates) {
  CamerasInput alone{.corners = input.corners,
                     .views = {},
                     .cameras = {input.cameras[camera]},
                     .lenses = {LensForm{}}};
  alone.cameras[0].fx = 0;  // the lens that it states would have an advantage
  for (const TargetView& view : input.views) {
    if (view.camera != static_cast<int>(camera)) continue;
    alone.views.push_back(view);
    alone.views.back().camera = 0;
  }
  CamerasInput trials = alone;
  trials.views = some_of(alone.views);
  // Each search begins at the same guess, which takes longer than a search.
  std::vector<const TargetView*> guessed;
  for (const TargetView& view : trials.views) guessed.push_back(&view);
  if (const auto guess = guessed_camera(alone.cameras[0], input.corners, guessed)) {
    trials.cameras = {*guess};
  }
  LensChoice choice;
  for (const LensForm& lens : candidates) {
    LensTrial trial{.lens = lens, .held_out_rms = kNaN, .fault = {}};
    trials.lenses = {lens};
    try {
      Squares squares;
      const std::vector<CamerasInput> halves = halves_of(trials);
      add_held_out(calibrate_cameras(halves[0]).cameras, halves[1], squares);
      add_held_out(calibrate_cameras(halves[1]).cameras, halves[0], squares);
      trial.held_out_rms = squares.rms();
    } catch (const InputError& error) {
      trial.fault = error.what();
    }
    choice.trials.push_back(trial);
  }
  // Halves may determine a lens that they do not together.
  while (LensTrial* const best = preferred(choice.trials)) {
    trials.lenses = {best->lens};
    try {
      calibrate_cameras(trials);
      choice.lens = best->lens;
      return choice;
    } catch (const InputError& error) {
      best->fault = error.what();
      best->held_out_rms = kNaN;
    }
  }
  throw InputError(fmt::format("cam{}: none of {} lenses has a calibration; the last: {}", camera,
                               candidates.size(), choice.trials.back().fault));
}

std::vector<std::optional<LensChoice>> choose_lenses(
    CamerasInput& input, const std::vector<std::vector<LensForm>>& candidates, bool from_nothing) {
  std::vector<std::optional<LensChoice>> choices;
  for (std::size_t c = 0; c < input.cameras.size(); ++c) {
    if (from_nothing) input.cameras[c].fx = 0;
    std::optional<LensChoice> choice;
    if (candidates[c].size() > 1) choice = choose_lens(input, c, candidates[c]);
    input.lenses.push_back(choice ? choice->lens : candidates[c][0]);
    choices.push_back(std::move(choice));
  }
  return choices;
}

std::vector<LensForm> common_lenses() {
  return {{Distortion::kRadtan, 4},
          {Distortion::kRadtan, 8},
          {Distortion::kEquidistant, 4},
          {Distortion::kDoubleSphere, 2},
          {Distortion::kEucm, 2}};
}

std::vector<LensForm> lens_candidates(const std::string& text, const std::string& setting) {
  if (text == "auto") return common_lenses();
  std::vector<LensForm> lenses;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    lenses.push_back(lens_form(text.substr(begin, end - begin), setting));
    begin = end + 1;
  }
  return lenses;
}

}  // namespace chasles
