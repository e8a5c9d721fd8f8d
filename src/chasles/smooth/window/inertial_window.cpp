#include <algorithm>
#include <optional>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/base/processor_time.hpp>
#include <chasles/base/validate.hpp>
#include <chasles/slam/inertial_calibration.hpp>
#include <chasles/slam/waiting_frames.hpp>
#include <chasles/smooth/batch/batch_solve_detail.hpp>
#include <chasles/smooth/window/inertial_window.hpp>
#include <chasles/smooth/window/window_tracks_detail.hpp>

namespace chasles {

using namespace smooth_detail;

struct InertialWindow::Implementation {
  using Tracks = WindowTracks<BatchPoint>;

  Implementation(const InertialBatchInput& in, const std::string& chart, const BatchSettings& s,
                 int keyframes)
      : input(sensors_of(in)),
        settings(validated(s)),
        report(),
        sliding(keyframes, settings, error_chart(chart), BlockSizes{}),
        buffer(input.imu),
        choice(input, settings, report.dropped_frames),
        gaps(input.start.time) {
    smooth_detail::check(input);
    report.window = keyframes;
    graph.anchored = sliding.window.anchored;
    add_start(input, graph);
    add_calibration(input, graph);
    if (graph.calibration) {
      smooth_detail::add_calibration(sliding.window, *graph.calibration, *input.calibration,
                                     graph.calibration_whitening, input.cameras.size());
      sliding.window.considered = {
          .rows = input.considered,
          .covariance = graph.calibration->covariance(input.considered, input.considered)};
    }
    graph.keyframes.push_back({.time = input.start.time, .state = graph.start});
  }

  static InertialBatchInput sensors_of(InertialBatchInput input) {
    input.samples.clear();
    input.frames.clear();
    input.initial.clear();
    input.imu.screened = true;
    return input;
  }

  void check_gap(Time frame) const;
  std::vector<Estimate> take_covered(bool all);
  std::optional<Estimate> take(const FeatureFrame& frame);
  void drop();
  void push_start();
  void push(Time time);
  void push_keyframe();
  void push_term(ChainTerm term);
  void observe(const PixelObservation& observation, int now);
  CalibratedTerm term_of(const PointView& view, const WindowPoint& point, double sigma) const;
  WindowView view_of(const PointView& view, const WindowPoint& point, int& matches) const;
  void hang_on_camera(const PointView& first, AnchorFace face, WindowPoint& point) const;
  void initialise_landmarks();
  void read_states();
  Estimate estimate(Time time, const SlidingWindow::Optimised& optimised);

  InertialBatchInput input;  // without samples and frames
  BatchSettings settings;
  WindowReport report;
  SlidingWindow sliding;
  BatchGraph graph;  // the states of the window's keyframes, and their links
  ImuBuffer buffer;
  KeyframeChoice choice;
  WaitingFrames<FeatureFrame> waiting;
  TimeGaps gaps;  // from the start on
  std::optional<TimeGaps::Gap> gap;
  Tracks tracks;
  std::vector<LandmarkId> seen;  // of the present frame, not in the window
  // Of each camera, as they may take turns: the keyframe of its last observations.
  std::vector<int> last_frames = std::vector<int>(input.cameras.size(), -1);
  RecentUse recent;
};

// The motion during a gap is unknown: a later frame cannot be linked to those before.
void InertialWindow::Implementation::check_gap(Time frame) const {
  if (gap && frame - gap->last > kLongestGap) reject_gap(gap->last, std::min(frame, gap->next));
}

std::vector<Estimate> InertialWindow::Implementation::take_covered(bool all) {
  std::vector<Estimate> estimates;
  const auto covered = [&](const FeatureFrame& frame) {
    return all || buffer.latest() >= frame.time + input.time_offset + readout_span(input);
  };
  while (const auto frame = waiting.next(covered)) {
    if (auto found = take(*frame)) estimates.push_back(std::move(*found));
  }
  return estimates;
}

std::optional<Estimate> InertialWindow::Implementation::take(const FeatureFrame& frame) {
  const double started = processor_seconds();
  const std::optional<Time> time = choice.take(frame, *buffer.latest());
  if (!time) return std::nullopt;
  check_gap(*time);
  if (sliding.make_room()) drop();
  if (sliding.window.keyframes.empty()) push_start();
  if (*time > graph.keyframes.back().time) push(*time);
  sliding.window.keyframes.back().framed = true;
  const int now = sliding.window.last();
  for (const PixelObservation& o : usable(frame, input.cameras, report.unusable)) observe(o, now);
  initialise_landmarks();
  const CameraSet looking = observing(frame);
  for (std::size_t c = 0; c < last_frames.size(); ++c) {
    if ((looking & camera_bit(static_cast<int>(c))) != 0) last_frames[c] = now;
  }
  const SlidingWindow::Optimised optimised = sliding.optimise(report);
  if (!optimised.finite) {
    throw Error(ExitCode::kDiverged, "the window found no finite minimum at the frame at " +
                                         std::to_string(frame.time.count()) + " ns");
  }
  tracks.drop(optimised.culled, report);
  read_states();
  report.imu = buffer.counts();
  Estimate found = estimate(*time, optimised);
  report.seconds += processor_seconds() - started;
  return found;
}

// Removes what has left the window.
void InertialWindow::Implementation::drop() {
  tracks.drop(sliding.window);
  graph.keyframes.drop_before(sliding.window.first);
  graph.links.drop_before(sliding.window.first);
}

void InertialWindow::Implementation::push_start() {
  set_readout(input, graph.imu(), buffer, graph.keyframes.back());
  push_keyframe();
  push_term({.cost = start_cost(graph)});
}

void InertialWindow::Implementation::push(Time time) {
  const Time from = graph.keyframes.back().time;
  const InertialState state = add_link(input, graph.keyframes.back(), time, buffer, graph);
  buffer.drop_before(from);
  graph.keyframes.push_back({.time = time, .state = state});
  set_readout(input, graph.imu(), buffer, graph.keyframes.back());
  push_keyframe();
  push_term({.first = sliding.window.last() - 1,
             .keyframes = 2,
             .cost = link_cost(graph, graph.links.back())});
}

void InertialWindow::Implementation::push_term(ChainTerm term) {
  const CalibrationBlocks& calibration = sliding.window.sizes.calibration;
  // Motion and biases of its keyframes, and in some the IMU's parameters.
  if (std::ssize(term.cost->parameter_block_sizes()) > 2 * term.keyframes) {
    term.calibration = calibration.all()[*calibration.of_imu()];
  }
  sliding.window.terms.push_back(std::move(term));
}

void InertialWindow::Implementation::push_keyframe() {
  const BatchKeyframe& keyframe = graph.keyframes.back();
  std::array<double, kMotionNumbers> motion{};
  write_motion(keyframe.state, motion.data());
  sliding.push(keyframe.time, motion.data(), keyframe.state.biases());
  ++report.keyframes;
}

void InertialWindow::Implementation::observe(const PixelObservation& o, int now) {
  Tracks::Track& track = tracks.of(o.landmark);
  std::vector<PointView>& views = track.of.views;
  const auto camera = static_cast<std::size_t>(o.camera);
  if (!settings.loops && !views.empty() && views.back().keyframe < last_frames[camera]) {
    track = {.of = {.id = o.landmark, .views = {}}};
  }
  views.push_back({.keyframe = now, .camera = o.camera, .pixel = o.pixel, .match = o.is_match()});
  if (!track.point) {
    seen.push_back(o.landmark);
    return;
  }
  const WindowPoint& point = sliding.window.points.at(*track.point);
  sliding.observe(*track.point, view_of(views.back(), point, track.matches));
  ++report.observations;
}

CalibratedTerm InertialWindow::Implementation::term_of(const PointView& view,
                                                       const WindowPoint& point,
                                                       double sigma) const {
  CalibratedTerm term = calibrated_term(input, graph, view, point.cam_T_imu, sigma);
  term.anchor = point.camera;
  if (term.anchor) {
    term.anchor->is_view = point.extrinsics == static_cast<std::size_t>(view.camera);
  }
  return term;
}

WindowView InertialWindow::Implementation::view_of(const PointView& view, const WindowPoint& point,
                                                   int& matches) const {
  const double sigma = sigma_of(input, view, matches);
  WindowView made =
      graph.calibration
          ? window_view(term_of(view, point, sigma), graph.anchored)
          : window_view(PixelTerm{.camera = &input.cameras[static_cast<std::size_t>(view.camera)],
                                  .cam_T_imu = cam_T_imu_of(input, graph, view),
                                  .of_anchor = point.cam_T_imu,
                                  .pixel = view.pixel,
                                  .sigma = sigma},
                        graph.anchored);
  made.keyframe = view.keyframe;
  made.camera = view.camera;
  made.match = view.match;
  return made;
}

// Called after all views of a frame are added.
void InertialWindow::Implementation::initialise_landmarks() {
  for (const LandmarkId id : std::exchange(seen, {})) {
    Tracks::Track& track = tracks.of(id);
    if (track.point || track.of.views.size() < 2) continue;
    BatchPoint point = track.of;
    if (!place(input, settings, true, graph, point)) continue;
    const PointView& first = point.views.front();
    WindowPoint made{.id = id,
                     .anchor = first.keyframe,
                     .cam_T_imu = anchor_T_imu(input, graph, point),
                     .parameters = point.parameters};
    hang_on_camera(first, point.face, made);
    track.matches = 0;
    for (const PointView& view : point.views) {
      made.views.push_back(view_of(view, made, track.matches));
    }
    if (graph.anchored) {
      made.alone = std::make_unique<InverseDepthCost>(settings.inverse_depth_sigma);
    }
    tracks.initialise(track, sliding.add(std::move(made)));
    ++report.landmarks;
    report.observations += static_cast<int>(point.views.size());
  }
}

// Lets the axes of an anchored landmark move with the estimated extrinsics of its camera. In axes
// that are fixed to the keyframe, an error of the extrinsics would move a landmark by an amount
// that depends on its depth, and the prior would seem to know these errors as soon as depths
// change.
void InertialWindow::Implementation::hang_on_camera(const PointView& first, AnchorFace face,
                                                    WindowPoint& point) const {
  if (!graph.anchored || !graph.calibration || graph.calibration->imu_T_camera.empty()) return;
  const Camera& camera = input.cameras[static_cast<std::size_t>(first.camera)];
  const BatchKeyframe& keyframe = graph.keyframes[static_cast<std::size_t>(first.keyframe)];
  point.camera = {.face = face,
                  .imu_T_line = imu_T_line(camera, motion_of(graph, keyframe), first.pixel)};
  point.extrinsics = static_cast<std::size_t>(first.camera);
  const SE3 before = point.cam_T_imu;
  update_axes(sliding.window, point);
  const SE3 change = point.cam_T_imu * before.inverse();
  const double w = point.parameters.z();
  const Eigen::Vector3d q =
      change.R * Eigen::Vector3d(point.parameters.x(), point.parameters.y(), 1) + w * change.p;
  point.parameters = Eigen::Vector3d(q.x(), q.y(), w) / q.z();
}

void InertialWindow::Implementation::read_states() {
  const Window& window = sliding.window;
  for (int k = window.first; k <= window.last(); ++k) {
    const WindowKeyframe& keyframe = window.keyframe(k);
    graph.keyframes[static_cast<std::size_t>(k)].state =
        read_state(keyframe.motion.data(), keyframe.additive.data());
  }
  if (!graph.calibration) return;
  read_calibration(window.calibration.data(), *graph.calibration);
  graph.cameras = calibrated(input.cameras, graph.calibration);
}

Estimate InertialWindow::Implementation::estimate(Time time,
                                                  const SlidingWindow::Optimised& optimised) {
  const InertialState& state = graph.keyframes.back().state;
  const Window& window = sliding.window;
  Estimate e;
  e.time = time;
  e.world_T_imu = state.world_T_imu;
  e.v_world = state.v_world;
  e.additive = state.biases();
  report.covariance_factor =
      settings.covariance_factor.value_or(sliding.walk().covariance_factor());
  e.covariance = sliding.newest_covariance(report.covariance_factor);
  if (graph.calibration) {
    e.calibration = graph.calibration;
    e.calibration->covariance = widened(report.covariance_factor, sliding.calibration_covariance(),
                                        graph.calibration->covariance, input.considered);
  }
  for (const auto& [number, point] : window.points) {
    e.used += static_cast<int>(std::ranges::count_if(
        point.views, [&](const WindowView& view) { return view.keyframe == window.last(); }));
  }
  e.observations = e.used;
  e.rejected = static_cast<int>(optimised.culled.views.size());
  e.in_state = static_cast<int>(window.points.size());
  e.landmarks = sliding.map_size();
  e.degradation = recent.assess(time, e.used, e.rejected, optimised.squares, optimised.residuals);
  if (e.degradation != Degradation::kNone) e.health = Health::kDegraded;
  return e;
}

InertialWindow::InertialWindow(const InertialBatchInput& input, const std::string& chart,
                               const BatchSettings& settings, int keyframes)
    : of_(std::make_unique<Implementation>(input, chart, settings, keyframes)) {}

InertialWindow::~InertialWindow() = default;

std::vector<Estimate> InertialWindow::process(const ImuSample& measured) {
  const auto gap = of_->gaps.add(measured.time);
  if (!of_->gap) of_->gap = gap;
  of_->buffer.add(measured);
  return of_->take_covered(false);
}

std::vector<Estimate> InertialWindow::process(const FeatureFrame& frame) {
  of_->waiting.add(frame);
  return of_->take_covered(false);
}

std::vector<Estimate> InertialWindow::finish() {
  if (!of_->waiting.empty() && !of_->buffer.latest()) {
    throw InputError("a window needs IMU samples: none in the recording is finite");
  }
  std::vector<Estimate> estimates = of_->take_covered(true);
  of_->report.imu = of_->buffer.counts();
  return estimates;
}

bool InertialWindow::waiting() const { return !of_->waiting.empty(); }

std::vector<MapLandmark> InertialWindow::map() const {
  return of_->sliding.map(of_->report.covariance_factor);
}

std::vector<LandmarkId> InertialWindow::in_window() const {
  std::vector<LandmarkId> ids;
  for (const auto& [number, point] : of_->sliding.window.points) ids.push_back(point.id);
  return ids;
}

Eigen::Vector3d InertialWindow::gyroscope_bias() const {
  return of_->graph.keyframes.back().state.gyroscope_bias;
}

const WindowReport& InertialWindow::report() const { return of_->report; }

void InertialWindow::check() const {
  if (of_->report.landmarks > 0) return;
  throw InputError(
      "a window needs landmarks that are observed twice: none in the recording is, or none with "
      "parallax (" +
      std::to_string(of_->report.unusable) + " observations were not usable)");
}

}  // namespace chasles
