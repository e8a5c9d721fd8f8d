#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/base/in_parallel.hpp>
#include <chasles/calibrate/camera_alone_detail.hpp>
#include <chasles/calibrate/camera_guess.hpp>
#include <chasles/calibrate/cross_validation.hpp>
#include <chasles/calibrate/projection_uncertainty.hpp>
#include <chasles/calibrate/target_pose.hpp>

namespace chasles {
namespace {

using calibrate_detail::calibrated_alone;
using calibrate_detail::kLeastCorners;
using calibrate_detail::kRough;

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

std::vector<const TargetView*> usable(const std::vector<TargetView>& views) {
  std::vector<const TargetView*> result;
  for (const TargetView& view : views) {
    if (view.ids.size() >= kLeastCorners) result.push_back(&view);
  }
  return result;
}

struct Squares {
  double sum = 0, corners = 0;
  double rms() const { return std::sqrt(sum / std::max(1.0, corners)); }
};

// Of views that took no part in the calibration. Each camera's views have poses of their own.
void add_held_out(const std::vector<Camera>& cameras, const CamerasInput& views, Squares& squares) {
  for (const TargetView& view : views.views) {
    if (view.ids.size() < kLeastCorners) continue;
    const auto pose =
        target_pose(cameras[static_cast<std::size_t>(view.camera)], views.corners, view, 1);
    const auto corners = static_cast<double>(view.ids.size());
    const double rms = pose ? std::min(pose->rms, kMissing) : kMissing;
    squares.sum += corners * rms * rms;
    squares.corners += corners;
  }
}

double rms_sigma(const CamerasCalibration& calibration, std::size_t camera) {
  return rms_of(
      projection_uncertainty(calibration.cameras[camera], lens_covariance(calibration, camera)));
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

// Those of one camera, with a first lens where one is found.
CamerasInput views_for_trials(const CamerasInput& input, std::size_t camera) {
  CamerasInput alone{.corners = input.corners,
                     .views = {},
                     .cameras = {input.cameras[camera]},
                     .lenses = {LensForm{}},
                     .shape = input.shape};
  alone.cameras[0].fx = 0;  // the lens that it states would have an advantage
  for (const TargetView& view : input.views) {
    if (view.camera != static_cast<int>(camera)) continue;
    alone.views.push_back(view);
    alone.views.back().camera = 0;
  }
  alone.views = some_of(alone.views);
  // Each search begins at the same guess, which takes longer than a search.
  if (const auto guess = guessed_camera(alone.cameras[0], input.corners, usable(alone.views))) {
    alone.cameras = {*guess};
  }
  return alone;
}

// Of each half under the lens of the other. Throws InputError where a half has none.
double held_out_rms(const CamerasInput& views, const LensForm& lens) {
  Squares squares;
  const std::vector<CamerasInput> halves = halves_of(views);
  for (std::size_t half = 0; half < 2; ++half) {
    const Camera camera = calibrated_alone(views.cameras[0], lens, views.corners,
                                           usable(halves[half].views), "cam0", kRough)
                              .camera;
    add_held_out({camera}, halves[1 - half], squares);
  }
  return squares.rms();
}

void give_up(LensTrial& trial, const InputError& error) {
  trial.fault = error.what();
  trial.held_out_rms = kNaN;
}

// Whether a camera has another lens than the one with which there was no calibration: the one of
// most parameters first.
bool take_another_lens(CamerasInput& input, std::vector<std::optional<LensChoice>>& choices,
                       const InputError& error) {
  std::vector<std::size_t> cameras;
  for (std::size_t c = 0; c < choices.size(); ++c) {
    if (choices[c]) cameras.push_back(c);
  }
  std::ranges::stable_sort(cameras, std::greater{},
                           [&](std::size_t c) { return input.lenses[c].parameters(); });
  for (const std::size_t c : cameras) {
    LensChoice without = *choices[c];
    give_up(*std::ranges::find(without.trials, without.lens, &LensTrial::lens), error);
    const LensTrial* const next = preferred(without.trials);
    if (next == nullptr) continue;
    without.lens = input.lenses[c] = next->lens;
    choices[c] = std::move(without);
    return true;
  }
  return false;
}

// The preferred lens that all views determine: halves may determine one that they do not together.
// Throws InputError where there is none.
LensForm chosen(std::vector<LensTrial>& trials, CamerasInput views, std::size_t camera) {
  while (LensTrial* const best = preferred(trials)) {
    views.lenses = {best->lens};
    try {
      calibrate_cameras(views);
      return best->lens;
    } catch (const InputError& error) {
      give_up(*best, error);
    }
  }
  throw InputError(fmt::format("cam{}: none of {} lenses has a calibration; the last: {}", camera,
                               trials.size(), trials.back().fault));
}

}  // namespace

HalvesComparison compare_halves(const CamerasInput& input, int threads) {
  const std::vector<CamerasInput> halves = halves_of(input);
  std::vector<CamerasCalibration> found(2);
  in_parallel(2, threads, [&](std::size_t i) { found[i] = calibrate_cameras(halves[i]); });
  const CamerasCalibration &a = found[0], &b = found[1];
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

std::vector<std::optional<LensChoice>> choose_lenses(
    CamerasInput& input, const std::vector<std::vector<LensForm>>& candidates, bool from_nothing,
    int threads) {
  const std::size_t cameras = input.cameras.size();
  std::vector<std::optional<LensChoice>> choices(cameras);
  std::vector<CamerasInput> alone(cameras);
  struct Task {
    std::size_t camera, lens;
  };
  std::vector<Task> tasks;
  for (std::size_t c = 0; c < cameras; ++c) {
    // The lens that is chosen is hardly the stated one, from which another may be a long way.
    if (from_nothing || candidates[c].size() > 1) input.cameras[c].fx = 0;
    if (candidates[c].size() < 2) continue;
    choices[c].emplace();
    for (const LensForm& lens : candidates[c]) {
      tasks.push_back({c, choices[c]->trials.size()});
      choices[c]->trials.push_back({.lens = lens, .held_out_rms = kNaN, .fault = {}});
    }
  }
  in_parallel(cameras, threads, [&](std::size_t c) {
    if (choices[c]) alone[c] = views_for_trials(input, c);
  });
  in_parallel(tasks.size(), threads, [&](std::size_t i) {
    LensTrial& trial = choices[tasks[i].camera]->trials[tasks[i].lens];
    try {
      trial.held_out_rms = held_out_rms(alone[tasks[i].camera], trial.lens);
    } catch (const InputError& error) {
      trial.fault = error.what();
    }
  });
  in_parallel(cameras, threads, [&](std::size_t c) {
    if (choices[c]) choices[c]->lens = chosen(choices[c]->trials, alone[c], c);
  });
  for (std::size_t c = 0; c < cameras; ++c) {
    input.lenses.push_back(choices[c] ? choices[c]->lens : candidates[c][0]);
  }
  return choices;
}

std::vector<std::optional<LensChoice>> calibrate_with_chosen_lenses(
    CamerasInput& input, const std::vector<std::vector<LensForm>>& candidates, bool from_nothing,
    int threads, const std::function<void()>& calibrate) {
  auto choices = choose_lenses(input, candidates, from_nothing, threads);
  while (true) {
    try {
      calibrate();
      return choices;
    } catch (const UndeterminedError& error) {
      if (!take_another_lens(input, choices, error)) throw;
    }
  }
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
