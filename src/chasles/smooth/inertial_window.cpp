#include <algorithm>
#include <utility>

#include <chasles/error.hpp>
#include <chasles/processor_time.hpp>
#include <chasles/smooth/batch_solve_detail.hpp>
#include <chasles/smooth/inertial_window.hpp>
#include <chasles/smooth/window_tracks_detail.hpp>

namespace chasles {
namespace {

using namespace smooth_detail;

class Run {
 public:
  Run(const BatchInput& input, const std::string& chart, const BatchSettings& settings,
      int keyframes)
      : input_(input),
        settings_(settings),
        sliding_(keyframes, settings, error_chart(chart), BlockSizes{}),
        buffer_(input.imu),
        choice_(input, settings, result_.report.dropped_frames),
        sample_(input.samples.begin()) {
    check_landmark_form(settings);
    check(input, settings);
    result_.report.window = keyframes;
    graph_.anchored = sliding_.window.anchored;
    add_start(input, graph_);
    graph_.keyframes.push_back({.time = input.start.time, .state = graph_.start});
  }

  InertialWindowResult run() {
    if (!input_.frames.empty() && !input_.samples.empty()) {
      check_gaps(
          input_, input_.start.time,
          std::min(input_.frames.back().time + input_.time_offset, input_.samples.back().time));
    }
    for (const FeatureFrame& frame : input_.frames) take(frame);
    if (result_.report.landmarks == 0) {
      throw InputError(
          "a window needs landmarks that are seen twice: none of the recording's is, or none with "
          "parallax (" +
          std::to_string(result_.report.unusable) + " observations were not usable)");
    }
    result_.landmarks = sliding_.map();
    for (const auto& [number, point] : sliding_.window.points) {
      result_.in_window.push_back(point.id);
    }
    result_.report.imu = buffer_.counts();
    return std::move(result_);
  }

 private:
  using Tracks = WindowTracks<BatchPoint>;

  // Up to the first one that is not before that time.
  void feed(Time time) {
    while (sample_ != input_.samples.end() && !(buffer_.latest() >= time)) buffer_.add(*sample_++);
    if (buffer_.latest()) return;
    throw InputError("a window needs IMU samples: none of the recording's is finite");
  }

  void take(const FeatureFrame& frame) {
    const double begun = processor_seconds();
    feed(frame.time + input_.time_offset);
    const std::optional<Time> time = choice_.take(frame, *buffer_.latest());
    if (!time) return;
    if (sliding_.make_room()) tracks_.forget(sliding_.window);
    if (sliding_.window.keyframes.empty()) push_start();
    if (*time > graph_.keyframes.back().time) push(*time);
    sliding_.window.keyframes.back().framed = true;
    const int now = sliding_.window.last();
    for (const PixelObservation& o : usable(frame, input_.cameras, result_.report.unusable)) {
      look(o, now);
    }
    begin_landmarks();
    last_frame_ = now;
    const SlidingWindow::Settled settled = sliding_.settle(result_.report);
    if (!settled.finite) {
      throw Error(ExitCode::kDiverged, "the window found no finite minimum at the frame at " +
                                           std::to_string(frame.time.count()) + " ns");
    }
    tracks_.forget(settled.culled, result_.report);
    read_states();
    note(*time, static_cast<int>(settled.culled.views.size()));
    result_.report.seconds += processor_seconds() - begun;
  }

  void push_start() {
    push_keyframe();
    sliding_.window.terms.push_back({.cost = std::make_unique<StartCost>(graph_)});
  }

  void push(Time time) {
    const Time from = graph_.keyframes.back().time;
    const InertialState state = add_link(input_, graph_.keyframes.back(), time, buffer_, graph_);
    buffer_.forget_before(from);
    graph_.keyframes.push_back({.time = time, .state = state});
    push_keyframe();
    sliding_.window.terms.push_back(
        {.first = sliding_.window.last() - 1,
         .keyframes = 2,
         .cost = std::make_unique<LinkCost>(graph_.links.back(), graph_.gravity)});
  }

  void push_keyframe() {
    const BatchKeyframe& keyframe = graph_.keyframes.back();
    std::array<double, kMotionNumbers> motion{};
    write_motion(keyframe.state, motion.data());
    sliding_.push(keyframe.time, motion.data(), keyframe.state.biases());
    ++result_.report.keyframes;
  }

  void look(const PixelObservation& o, int now) {
    Tracks::Track& track = tracks_.of(o.landmark);
    std::vector<PointView>& views = track.of.views;
    if (!settings_.loops && !views.empty() && views.back().keyframe < last_frame_) {
      track = {.of = {.id = o.landmark, .views = {}}};
    }
    views.push_back({.keyframe = now, .camera = o.camera, .pixel = o.pixel});
    if (!track.point) {
      seen_.push_back(o.landmark);
      return;
    }
    const int anchor_camera = sliding_.window.points.at(*track.point).camera;
    sliding_.look(*track.point, view_of(views.back(), anchor_camera));
    ++result_.report.observations;
  }

  WindowView view_of(const PointView& view, int anchor_camera) const {
    const auto camera = [&](int i) { return &input_.cameras[static_cast<std::size_t>(i)]; };
    WindowView made = window_view(PixelTerm{.camera = camera(view.camera),
                                            .anchor_camera = camera(anchor_camera),
                                            .pixel = view.pixel,
                                            .sigma = input_.pixel_sigma},
                                  graph_.anchored);
    made.keyframe = view.keyframe;
    made.camera = view.camera;
    return made;
  }

  // After all views of a frame are there.
  void begin_landmarks() {
    for (const LandmarkId id : std::exchange(seen_, {})) {
      Tracks::Track& track = tracks_.of(id);
      if (track.point || track.of.views.size() < 2) continue;
      BatchPoint point = track.of;
      if (!place(input_, settings_, true, graph_, point)) continue;
      const PointView& first = point.views.front();
      WindowPoint made{
          .id = id,
          .anchor = first.keyframe,
          .camera = first.camera,
          .cam_T_imu = input_.cameras[static_cast<std::size_t>(first.camera)].cam_T_imu,
          .parameters = point.parameters};
      for (const PointView& view : point.views) made.views.push_back(view_of(view, first.camera));
      if (graph_.anchored) {
        made.alone = std::make_unique<InverseDepthCost>(settings_.inverse_depth_sigma);
      }
      tracks_.begin(track, sliding_.add(std::move(made)));
      ++result_.report.landmarks;
      result_.report.observations += static_cast<int>(point.views.size());
    }
  }

  void read_states() {
    const Window& window = sliding_.window;
    for (int k = window.first; k <= window.last(); ++k) {
      const WindowKeyframe& keyframe = window.keyframe(k);
      graph_.keyframes[static_cast<std::size_t>(k)].state =
          read_state(keyframe.motion.data(), keyframe.additive.data());
    }
  }

  void note(Time time, int rejected) {
    const InertialState& state = graph_.keyframes.back().state;
    const Window& window = sliding_.window;
    WindowMotion& m = result_.motions.emplace_back();
    m.time = time;
    m.motion.nav_T_imu = state.world_T_imu;
    m.motion.v_nav = state.v_world;
    m.motion.biases = state.biases();
    m.motion.covariance = sliding_.newest_covariance();
    for (const auto& [number, point] : window.points) {
      m.observations += static_cast<int>(std::ranges::count_if(
          point.views, [&](const WindowView& view) { return view.keyframe == window.last(); }));
    }
    m.rejected = rejected;
    m.in_window = static_cast<int>(window.points.size());
    m.landmarks = sliding_.map_size();
    m.health = recent_.judge(time, m.observations, rejected);
  }

  const BatchInput& input_;
  const BatchSettings& settings_;
  InertialWindowResult result_;
  SlidingWindow sliding_;
  BatchGraph graph_;  // the states of all keyframes, and their links
  ImuBuffer buffer_;
  KeyframeChoice choice_;
  std::vector<ImuSample>::const_iterator sample_;
  Tracks tracks_;
  std::vector<LandmarkId> seen_;  // of the present frame, not in the window
  int last_frame_ = -1;
  RecentUse recent_;
};

}  // namespace

InertialWindowResult slide(const BatchInput& input, const std::string& chart,
                           const BatchSettings& settings, int keyframes) {
  return Run(input, chart, settings, keyframes).run();
}

}  // namespace chasles
