#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/camera/track_noise.hpp>
#include <chasles/camera/triangulation.hpp>
#include <chasles/filter/readout.hpp>
#include <chasles/imu/sample_screen.hpp>
#include <chasles/imu/time_gaps.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/slam/inertial_calibration.hpp>
#include <chasles/smooth/batch/batch_graph_detail.hpp>
#include <chasles/smooth/batch/batch_solve_detail.hpp>
#include <chasles/smooth/batch/floors_detail.hpp>
#include <chasles/smooth/batch/initial_error_detail.hpp>
#include <chasles/smooth/terms/calibration_blocks_detail.hpp>

namespace chasles::smooth_detail {
namespace {

// Initial value of an inverse depth that its rays do not determine [1/m].
constexpr double kGuessedInverseDepth = 0.1;
// Samples of that time show the motion by which another time offset moves an image [s].
constexpr double kTimeOffsetSpan = 0.01;

// The samples that are measurements, and the counts of the others.
struct Measured {
  explicit Measured(const InertialBatchInput& input) : samples(input.samples) {
    if (input.imu.screened) return;
    SampleScreen screen(input.imu.range());
    for (const ImuSample& sample : input.samples) {
      const auto released = screen.add(sample);
      own.insert(own.end(), released.begin(), released.end());
    }
    samples = own;
    left_out = screen.counts();
  }

  std::vector<ImuSample> own;
  std::span<const ImuSample> samples;
  SampleScreen::Counts left_out;
};

ImuBuffer buffer_of(const InertialBatchInput& input, const Measured& measured) {
  ImuBuffer::Options options = input.imu;
  options.screened = true;
  ImuBuffer buffer(options);
  for (const ImuSample& sample : measured.samples) buffer.add(sample);
  if (!buffer.latest()) {
    throw InputError("batch estimation needs IMU samples: none in the recording is finite");
  }
  return buffer;
}

void correct(const ImuCorrection* imu, std::vector<ImuInterval>& intervals) {
  if (imu == nullptr) return;
  for (ImuInterval& interval : intervals) interval = corrected(*imu, interval);
}

InertialState start_state(const InertialStart& start) {
  return {.world_T_imu = start.nav_T_imu,
          .v_world = start.v_nav,
          .accelerometer_bias = start.accelerometer_bias,
          .gyroscope_bias = start.gyroscope_bias};
}

// Initial states and links, from one keyframe to the next.
void add_motion(const InertialBatchInput& input, ImuBuffer& buffer, BatchGraph& graph) {
  Numbered<BatchKeyframe>& keyframes = graph.keyframes;
  keyframes.front().state = graph.start;
  for (std::size_t k = 0; k + 1 < keyframes.size(); ++k) {
    const InertialState predicted =
        add_link(input, keyframes[k], keyframes[k + 1].time, buffer, graph);
    const auto known =
        std::ranges::lower_bound(input.initial, keyframes[k + 1].time, {}, &TimedMotion::time);
    const bool is_known = known != input.initial.end() && known->time == keyframes[k + 1].time;
    keyframes[k + 1].state = is_known ? known->state : predicted;
  }
  for (BatchKeyframe& keyframe : keyframes) set_readout(input, graph.imu(), buffer, keyframe);
}

// The values at which a search begins. Considered ones are those of the prior.
Calibration first_calibration(const InertialBatchInput& input) {
  const CalibrationBlocks blocks(input.calibration);
  const auto n = static_cast<std::size_t>(blocks.numbers());
  std::vector<double> stated(n), initial(n);
  write_calibration(*input.calibration, stated.data());
  Calibration first = *input.calibration;
  for (std::size_t i = 0; i < input.cameras.size(); ++i) {
    const Camera& camera = input.cameras[i];
    if (!first.imu_T_camera.empty()) first.imu_T_camera[i] = camera.cam_T_imu.inverse();
    if (first.intrinsics.empty()) continue;
    first.intrinsics[i] = intrinsics_of(camera);
    first.intrinsics[i].has_lens = input.calibration->intrinsics[i].has_lens;
    first.intrinsics[i].has_readout = input.calibration->intrinsics[i].has_readout;
  }
  if (first.time_offset) first.time_offset = to_seconds(input.time_offset);
  write_calibration(first, initial.data());
  for (const auto& block : blocks.all()) {
    for (const int row : input.considered) {
      if (row < block.row || row >= block.row + block.errors) continue;
      const int of_row = block.is_pose ? block.number : block.number + row - block.row;
      std::copy_n(stated.data() + of_row, block.is_pose ? block.numbers : 1,
                  initial.data() + of_row);
    }
  }
  read_calibration(initial.data(), first);
  return first;
}

void check_calibration(const InertialBatchInput& input) {
  const Calibration& c = *input.calibration;
  const std::size_t cameras = input.cameras.size();
  const auto fits = [&](std::size_t count) { return count == 0 || count == cameras; };
  const int rows = CalibrationBlocks(input.calibration).errors();
  const auto of_imu = c.imu && input.start.by_imu.size() > 0 ? input.start.by_imu.cols() : 0;
  if (of_imu > 0 && (of_imu != c.imu->size() || input.start.by_imu.rows() != 15)) {
    throw UsageError("batch estimation of the IMU's parameters: found a start that depends on " +
                     std::to_string(of_imu) + " of them, expected all " +
                     std::to_string(c.imu->size()));
  }
  if (!fits(c.imu_T_camera.size()) || !fits(c.intrinsics.size()) || c.covariance.rows() != rows ||
      c.covariance.cols() != rows) {
    throw UsageError(
        "batch estimation of a calibration: found " + std::to_string(c.imu_T_camera.size()) +
        " extrinsics, " + std::to_string(c.intrinsics.size()) + " intrinsics and a covariance of " +
        std::to_string(c.covariance.rows()) + " rows, expected those of " +
        std::to_string(cameras) + " cameras or none, and " + std::to_string(rows) + " rows");
  }
  for (const int row : input.considered) {
    if (row >= 0 && row < rows) continue;
    throw UsageError("batch estimation of a calibration: found a considered row " +
                     std::to_string(row) + ", expected one of its " + std::to_string(rows) +
                     " errors");
  }
}

std::vector<View> views_of(const InertialBatchInput& input, const BatchGraph& graph,
                           const BatchPoint& point, std::vector<Camera>& at_lines) {
  at_lines.reserve(point.views.size());
  std::vector<View> views;
  const double late = graph.late(input);
  for (const PointView& view : point.views) {
    const BatchKeyframe& keyframe = graph.keyframes[static_cast<std::size_t>(view.keyframe)];
    const Camera* camera = &graph.cameras[static_cast<std::size_t>(view.camera)];
    if (camera->shutter.is_rolling() || late != 0) {
      const double delay = line_delay(*camera, view.pixel) + late;
      Camera& at = at_lines.emplace_back(*camera);
      at.cam_T_imu = at.cam_T_imu * motion_of(graph, keyframe).after(delay).inverse();
      camera = &at;
    }
    views.push_back(
        {.world_T_imu = keyframe.state.world_T_imu, .camera = camera, .pixel = view.pixel});
  }
  return views;
}

}  // namespace

void check(const InertialBatchInput& input) {
  if (input.cameras.empty()) throw InputError("batch estimation needs a camera: there is none");
  if (!(input.pixel_sigma > 0) || !std::isfinite(input.pixel_sigma)) {
    throw UsageError("pixel_sigma: found " + std::to_string(input.pixel_sigma) +
                     ", expected a standard deviation above 0");
  }
}

double sigma_of(const InertialBatchInput& input, const PointView& view, int& matches) {
  const TrackNoise noise{.sigma = input.pixel_sigma, .drift = 0, .match = input.match_sigma};
  if (!view.match) return noise.sigma;
  return std::sqrt(noise.sigma * noise.sigma + noise.match_variance(++matches));
}

void reject_gap(Time last, Time next) {
  throw InputError(
      "the IMU has no sample between " + std::to_string(last.count()) + " ns and " +
      std::to_string(next.count()) + " ns: the motion in " +
      std::to_string(to_seconds(next - last)) +
      " s without samples is unknown (expected gaps of at most 0.5 s); estimate the parts before "
      "and after the gap separately (--start, --stop), or use the filter");
}

void check_gaps(std::span<const ImuSample> measured, Time from, Time to) {
  TimeGaps gaps(from);
  for (const ImuSample& sample : measured) {
    if (sample.time >= to) break;
    if (const auto gap = gaps.add(sample.time)) reject_gap(gap->last, gap->next);
  }
  if (to - *gaps.last() > kLongestGap) reject_gap(*gaps.last(), to);
}

void add_start(const InertialBatchInput& input, BatchGraph& graph) {
  graph.start = start_state(input.start);
  Vector15d floor = Vector15d::Constant(kFloor * kFloor);
  floor.tail<3>().setConstant(kRateFloor * kRateFloor);
  graph.start_covariance = input.start_covariance;
  graph.start_covariance.diagonal() += floor;
  const std::optional<Eigen::MatrixXd> whitening = whitening_of(graph.start_covariance);
  if (!whitening) throw InputError("the start's covariance is not positive semidefinite");
  graph.start_whitening = *whitening;
  if (!input.calibration || !input.calibration->imu) return;
  graph.start_by_imu = input.start.by_imu;
  const auto& own = input.start.calibration;
  const ImuCorrection& at = own && own->imu ? *own->imu : *input.calibration->imu;
  graph.imu_of_start = at.parameters();
}

void add_calibration(const InertialBatchInput& input, BatchGraph& graph) {
  graph.cameras = input.cameras;
  if (!input.calibration) return;
  check_calibration(input);
  graph.calibration = first_calibration(input);
  graph.cameras = calibrated(input.cameras, graph.calibration);
  graph.calibration->covariance.diagonal().array() += kFloor * kFloor;
  const std::optional<Eigen::MatrixXd> whitening = whitening_of(graph.calibration->covariance);
  if (!whitening) throw InputError("the calibration's covariance is not positive semidefinite");
  graph.calibration_whitening = *whitening;
}

InertialState add_link(const InertialBatchInput& input, const BatchKeyframe& from, Time to,
                       ImuBuffer& buffer, BatchGraph& graph) {
  graph.links.push_back(imu_link(buffer.between(from.time, to), from.state.biases(), input.noise));
  std::vector<ImuInterval> intervals = graph.links.back().intervals;
  correct(graph.imu(), intervals);
  InertialState state = from.state;
  for (const ImuInterval& interval : intervals) state = integrate(state, interval, graph.gravity);
  return state;
}

bool place(const InertialBatchInput& input, const BatchSettings& settings, bool good_poses,
           const BatchGraph& graph, BatchPoint& point) {
  std::vector<Camera> at_lines;
  const std::vector<View> views = views_of(input, graph, point, at_lines);
  const auto found = triangulate(views);
  const bool wide = found && found->parallax >= settings.min_parallax;
  // With good poses, rays that do not meet belong to a wrong track, and a depth that is hardly
  // determined prevents convergence. With poor poses, neither can be decided.
  if (!wide && (!graph.anchored || good_poses)) return false;
  if (!graph.anchored) {
    point.parameters = found->p_world;
    return true;
  }
  const View& first = views.front();
  if (found) {
    const SE3 cam_T_imu = cam_T_imu_of(input, graph, point.views.front());
    const Eigen::Vector3d p_cam = cam_T_imu * (first.world_T_imu.inverse() * found->p_world);
    point.face = face_towards(p_cam);
    point.parameters = inverse_depth_in(point.face, p_cam, 1);
    return true;
  }
  const auto ray = face_ray(*first.camera, first.pixel);
  if (!ray) return false;
  point.face = ray->face;
  point.parameters << ray->xy, kGuessedInverseDepth;
  return true;
}

BatchGraph batch_graph(const InertialBatchInput& input, const BatchSettings& settings,
                       BatchReport& report) {
  check(input);
  const Measured measured(input);
  ImuBuffer buffer = buffer_of(input, measured);
  Tracked tracked = track(input, settings, *buffer.latest(), report);
  BatchGraph graph{.keyframes = std::move(tracked.keyframes)};
  if (graph.keyframes.size() < 2) {
    throw InputError(
        "batch estimation needs two frames with samples between them: there are " +
        std::to_string(input.frames.size()) + " frames, " + std::to_string(report.dropped_frames) +
        " of them late, repeated or without samples nearby, or none later than the start's time");
  }
  check_gaps(measured.samples, graph.keyframes.front().time, graph.keyframes.back().time);
  graph.anchored = settings.landmarks == LandmarkForm::kInverseDepth;
  add_start(input, graph);
  add_calibration(input, graph);
  add_motion(input, buffer, graph);
  for (BatchPoint& point : tracked.points) {
    if (!place(input, settings, !input.initial.empty(), graph, point)) {
      ++report.landmarks_left_out;
      continue;
    }
    for (const PointView& view : point.views) {
      ++graph.keyframes[static_cast<std::size_t>(view.keyframe)].observations;
      ++report.observations;
    }
    graph.points.push_back(std::move(point));
  }
  if (graph.points.empty()) {
    throw InputError("batch estimation needs landmarks that are observed twice: of " +
                     std::to_string(report.landmarks_left_out) +
                     " landmarks none is, or none with parallax (" +
                     std::to_string(report.unusable) + " observations were not usable)");
  }
  report.keyframes = static_cast<int>(graph.keyframes.size());
  report.links = static_cast<int>(graph.links.size());
  report.landmarks = static_cast<int>(graph.points.size());
  report.imu = buffer.counts();
  if (!input.imu.screened) report.imu.note(measured.left_out);
  add_initial_error(input, settings, graph);
  return graph;
}

Clone anchor_of(const BatchGraph& graph, const BatchPoint& point) {
  const int k = point.views.front().keyframe;
  return {.id = k, .world_T_imu = graph.keyframes[static_cast<std::size_t>(k)].state.world_T_imu};
}

SE3 cam_T_imu_of(const InertialBatchInput& input, const BatchGraph& graph, const PointView& view) {
  const Camera& camera = input.cameras[static_cast<std::size_t>(view.camera)];
  if (!camera.shutter.is_rolling()) return camera.cam_T_imu;
  const BatchKeyframe& keyframe = graph.keyframes[static_cast<std::size_t>(view.keyframe)];
  return at_line(camera, motion_of(graph, keyframe), view.pixel).cam_T_imu;
}

SE3 anchor_T_imu(const InertialBatchInput& input, const BatchGraph& graph,
                 const BatchPoint& point) {
  return face_T_imu(point.face, cam_T_imu_of(input, graph, point.views.front()));
}

ReadoutMotion motion_of(const BatchGraph& graph, const BatchKeyframe& keyframe) {
  const InertialState& state = keyframe.state;
  return keyframe.readout.motion(state.world_T_imu.R, state.v_world, graph.gravity);
}

Time readout_span(const InertialBatchInput& input) {
  const bool moves = input.calibration && input.calibration->time_offset;
  return from_seconds(std::max(longest_readout(input.cameras), moves ? kTimeOffsetSpan : 0));
}

void set_readout(const InertialBatchInput& input, const ImuCorrection* imu, ImuBuffer& buffer,
                 BatchKeyframe& keyframe) {
  const Time readout = readout_span(input);
  if (readout <= Time{}) return;
  std::vector<ImuInterval> intervals = buffer.between(keyframe.time, keyframe.time + readout);
  correct(imu, intervals);
  keyframe.readout = measured_readout(intervals, keyframe.state.biases());
}

Landmark landmark_of(const InertialBatchInput& input, const BatchGraph& graph,
                     const BatchPoint& point) {
  Landmark landmark{.id = point.id};
  landmark.anchor = point.views.front().keyframe;
  landmark.camera = point.views.front().camera;
  landmark.face = point.face;
  landmark.cam_T_imu = anchor_T_imu(input, graph, point);
  landmark.inverse_depth = point.parameters;
  return landmark;
}

Vector15d start_error(const BatchGraph& graph, const InertialState& state) {
  const InertialState& from = graph.start;
  Vector15d e;
  e << so3::log(state.world_T_imu.R * from.world_T_imu.R.transpose()),
      state.world_T_imu.p - from.world_T_imu.p, state.v_world - from.v_world,
      state.biases() - from.biases();
  return e;
}

Vector15d start_residual(const BatchGraph& graph, const InertialState& state,
                         Matrix15d* derivative) {
  const Vector15d e = start_error(graph, state);
  if (derivative != nullptr) {
    *derivative = graph.start_whitening;
    derivative->leftCols<3>() *= so3::left_jacobian_inverse(e.head<3>());
  }
  return graph.start_whitening * e;
}

}  // namespace chasles::smooth_detail
