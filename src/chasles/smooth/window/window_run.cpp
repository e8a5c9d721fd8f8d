#include <algorithm>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/slam/inertial_session.hpp>
#include <chasles/smooth/window/window_run_detail.hpp>

namespace chasles::smooth_detail {

SlidingWindow::SlidingWindow(int keyframes, const BatchSettings& settings, const ErrorChart& chart,
                             const BlockSizes& sizes)
    : keyframes_(keyframes), settings_(settings) {
  dense::prepare();
  if (keyframes < 2) {
    throw UsageError("a window of " + std::to_string(keyframes) +
                     " keyframes: expected window:N with N of 2 or more");
  }
  window.sizes = sizes;
  window.chart = &chart;
  window.loss.reset(loss_of(settings));
  window.anchored = settings.landmarks == LandmarkForm::kInverseDepth;
}

int SlidingWindow::push(Time time, const double* motion, const Eigen::VectorXd& additive) {
  WindowKeyframe keyframe{.time = time, .additive = additive};
  std::copy_n(motion, window.sizes.motion(), keyframe.motion.begin());
  window.keyframes.push_back(std::move(keyframe));
  return window.last();
}

int SlidingWindow::add(WindowPoint point) {
  point.observations = static_cast<int>(point.views.size());
  window.points.emplace(next_point_, std::move(point));
  return next_point_++;
}

void SlidingWindow::observe(int number, WindowView view) {
  WindowPoint& point = window.points.at(number);
  point.views.push_back(std::move(view));
  ++point.observations;
}

bool SlidingWindow::make_room() {
  if (std::ranges::count_if(window.keyframes, &WindowKeyframe::framed) < keyframes_) return false;
  refresh();
  const auto oldest = std::ranges::find_if(window.keyframes, &WindowKeyframe::framed);
  const int until = window.first + static_cast<int>(oldest - window.keyframes.begin());
  for (const int number : ending_points(window, until)) {
    if (const auto landmark = map_landmark(window, factor_, number)) left_.push_back(*landmark);
  }
  note_walk(until);
  while (window.first <= until) marginalise_oldest(window);
  return true;
}

// Of the landmarks that this keyframe and two later ones have observed; every triple of views is
// noted once, when its first keyframe leaves.
void SlidingWindow::note_walk(int keyframe) {
  // The walk of stereo tracks is part of their noise.
  if (!window.sizes.velocity || settings_.covariance_factor) return;
  for (const auto& [number, point] : window.points) {
    const std::vector<WindowView>& views = point.views;
    for (std::size_t a = 0; a < views.size(); ++a) {
      if (views[a].keyframe != keyframe || views[a].match) continue;
      const std::size_t b = next_view(views, a);
      const std::size_t c = b < views.size() ? next_view(views, b) : b;
      if (c >= views.size()) continue;
      const Time duration =
          window.keyframe(views[c].keyframe).time - window.keyframe(keyframe).time;
      walk_.add(residual(window, point, views[a]), residual(window, point, views[b]),
                residual(window, point, views[c]), to_seconds(duration));
    }
  }
}

void SlidingWindow::refresh() {
  evaluate(window);  // after the gate
  if (!factor_.fits(window))
    factor_ = factor_of(window);  // velocities may come after the last frame
}

SlidingWindow::Optimised SlidingWindow::optimise(WindowReport& report) {
  const double near = settings_.window_precision;
  const WindowProgress progress = improve(window,
                                          {.steps = settings_.window_steps,
                                           .tolerance = settings_.tolerance,
                                           .least_decrease = near * near / 2},
                                          factor_);
  report.steps += progress.tried;
  report.steps_rejected += progress.tried - progress.successful;
  report.frames_not_converged += progress.converged ? 0 : 1;
  Optimised optimised{.culled = {}, .finite = progress.finite};
  const double gate = settings_.gate_sigmas();
  if (gate > 0 && progress.finite) optimised.culled = cull(window, gate);
  for (const CulledView& view : optimised.culled.views) --window.points.at(view.point).observations;
  for (const int number : optimised.culled.points) window.points.erase(number);
  for (const auto& [number, point] : window.points) {
    for (const WindowView& view : point.views) {
      optimised.squares += view.whitened_norm * view.whitened_norm;
      optimised.residuals += view.rows();
    }
  }
  return optimised;
}

std::vector<MapLandmark> SlidingWindow::map(double covariance_factor) {
  refresh();
  std::vector<MapLandmark> all;
  const auto add = [&](const WindowLandmark& of) {
    MapLandmark& landmark = all.emplace_back(of.landmark);
    landmark.covariance = covariance_factor * landmark.covariance + of.added;
  };
  std::ranges::for_each(left_, add);
  for (const auto& [number, point] : window.points) {
    if (const auto landmark = map_landmark(window, factor_, number)) add(*landmark);
  }
  return all;
}

}  // namespace chasles::smooth_detail

namespace chasles {

void add(const WindowReport& more, WindowReport& sum) {
  sum.window = more.window;
  for (int WindowReport::*count :
       {&WindowReport::keyframes, &WindowReport::observations, &WindowReport::unusable,
        &WindowReport::gated, &WindowReport::dropped_frames, &WindowReport::landmarks,
        &WindowReport::steps, &WindowReport::steps_rejected, &WindowReport::frames_not_converged}) {
    sum.*count += more.*count;
  }
  sum.covariance_factor = more.covariance_factor;
  add(more.imu, sum.imu);
  sum.seconds += more.seconds;
}

}  // namespace chasles
