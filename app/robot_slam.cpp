#include "robot_slam.hpp"

#include <algorithm>
#include <atomic>
#include <utility>

#include <fmt/format.h>

#include <chasles/data/image_recording.hpp>
#include <chasles/data/masks.hpp>
#include <chasles/error.hpp>
#include <chasles/overloaded.hpp>
#include <chasles/pipeline/map_file.hpp>
#include <chasles/pipeline/recording_sensors.hpp>

#include "map_output.hpp"
#include "output_folder.hpp"
#include "robot_latency.hpp"
#include "robot_log.hpp"

namespace chasles::app {
namespace {

// Images that are there, and will come.
class ImagesOfDrivers : public ImageSource {
 public:
  std::size_t size() const override { return 0; }
  Time time(std::size_t) const override { return {}; }
  ImageFrame read(std::size_t) const override { return {}; }
};

// The sensors as a recording has them, so that all decisions are those of `chasles run`.
Recording sensors_of(const RobotSetup& setup) {
  const SensorCalibration& c = setup.calibration;
  Recording sensors;
  sensors.name = setup.name;
  sensors.cameras = c.cameras;
  sensors.imu_convention = c.imu_convention;
  sensors.imu_noise = c.imu_noise;
  sensors.imu_range = corrected_range(c);
  sensors.single_pixel_sigma = c.single_pixel_sigma;
  sensors.exact_calibration = c.exact_calibration;
  sensors.remarks = c.remarks;
  sensors.images = std::make_shared<const ImagesOfDrivers>();
  return sensors;
}

void check_setup(RobotSetup& setup) {
  if (setup.calibration.cameras.empty()) {
    throw UsageError("the calibration has no camera, expected one or more");
  }
  if (setup.settings.estimator.is_batch()) {
    throw UsageError(
        "estimator: found 'batch', expected filter or window:N: batch estimation needs a whole "
        "recording (chasles run)");
  }
  const bool uses_maps = !setup.map.empty() || setup.saves_map;
  if (uses_maps && !setup.settings.estimator.is_filter()) {
    throw UsageError("maps are for the filter, not for the estimator " +
                     name_of(setup.settings.estimator));
  }
  if (uses_maps) setup.settings.filter.recognise = Recognise::kAppearance;
  setup.calibration.time_offsets.resize(setup.calibration.cameras.size());
}

}  // namespace

// From a start or reset to the next.
struct RobotSlam::Session {
  Session(std::unique_ptr<VisualInertialSlam> made, const RobotSetup& setup,
          const Recording& sensors, const InertialRunSettings& of_run,
          const RealtimeSlam::Callback& on_estimates)
      : predictor(made->predictor()),
        order({.cameras = setup.calibration.cameras.size(),
               .patience = setup.lossless ? Time::max() : SensorOrder::Options{}.patience}),
        callback(on_estimates) {
    if (setup.keeps_run) {
      log.emplace(sensors, setup.settings, of_run, made->estimator());
      made->set_frame_observer([this](const FeatureFrame& frame) { log->add(frame); });
    }
    slam.emplace(std::move(made),
                 RealtimeSlam::Options{.most_images = setup.lossless ? 0 : setup.most_images},
                 [this](std::span<const Estimate> estimates, VisualInertialSlam& of) {
                   note(estimates, of);
                 });
  }

  // On the estimator's thread.
  void note(std::span<const Estimate> estimates, VisualInertialSlam& of) {
    if (estimates.empty() || ended) return;
    for (const Estimate& e : estimates) latency.estimated(e.time);
    {
      const std::lock_guard lock(state_mutex);
      predictor.correct(estimates.back());
      last = estimates.back();
    }
    if (log) log->add(estimates);
    if (callback) callback(estimates, of);
  }

  mutable std::mutex state_mutex;  // of the next three
  StatePredictor predictor;
  std::optional<Estimate> last;
  std::size_t samples = 0;

  std::mutex order_mutex;  // of the order, and of passing on what it returns
  SensorOrder order;

  std::optional<RobotLog> log;  // of the estimator's thread
  RobotLatency latency;
  std::atomic<bool> ended = false;
  RealtimeSlam::Callback callback;
  std::optional<RealtimeSlam> slam;  // last, because its thread uses all members above
};

RobotSlam::RobotSlam(RobotSetup setup, Callbacks callbacks)
    : setup_(std::move(setup)), callbacks_(std::move(callbacks)) {
  check_setup(setup_);
  if (!setup_.map.empty()) prior_ = std::make_shared<const LandmarkMap>(read_map(setup_.map));
  session_ = make_session();
}

RobotSlam::~RobotSlam() = default;

std::shared_ptr<RobotSlam::Session> RobotSlam::make_session() const {
  const Recording sensors = sensors_of(setup_);
  const InertialRunSettings of_run = decided(setup_.settings, sensors);
  auto slam = std::make_unique<VisualInertialSlam>(
      sensors.cameras, *sensors.imu_noise, of_run, imu_options(sensors),
      read_masks(of_run.frontend.mask, sensors.cameras), prior_);
  return std::make_shared<Session>(std::move(slam), setup_, sensors, of_run,
                                   callbacks_.on_estimates);
}

std::shared_ptr<RobotSlam::Session> RobotSlam::session() const {
  const std::lock_guard lock(mutex_);
  return session_;
}

ImuNoise RobotSlam::imu_noise() const {
  const InertialRunSettings of_run = decided(setup_.settings, sensors_of(setup_));
  return scaled(setup_.calibration.imu_noise, of_run.filter.imu_noise_scale.value_or(1));
}

// An exception is one of the estimator, which has ended.
template <typename Work>
void RobotSlam::feed(const Work& work) {
  const auto session = this->session();
  std::string jump;
  try {
    jump = work(*session);
  } catch (const std::exception& error) {
    restart(session, fmt::format("the estimator ended: {}", error.what()));
  }
  if (jump.empty()) return;
  restart(session, jump);
  work(*this->session());
}

void RobotSlam::add(const ImuSample& measured) {
  const ImuSample sample = corrected_sample(setup_.calibration, measured);
  feed([&](Session& session) -> std::string {
    const std::lock_guard lock(session.order_mutex);
    if (session.order.jumps_back(sample.time)) return "the stamps of the IMU jumped back";
    {
      const std::lock_guard state_lock(session.state_mutex);
      session.predictor.add(sample);
      ++session.samples;
    }
    session.order.add(sample);
    pass_on(session, session.order.take());
    return {};
  });
}

void RobotSlam::add(std::size_t camera, Time stamp, GrayImage image, Clock::time_point arrived) {
  const Camera& expected = cameras().at(camera);
  if (!image.empty() && (image.width != expected.width || image.height != expected.height)) {
    throw InputError(
        fmt::format("cam{}: an image has {} x {} pixels, expected {} x {} as in the "
                    "calibration",
                    camera, image.width, image.height, expected.width, expected.height));
  }
  const Time time =
      by_imu_clock(stamp, setup_.calibration.time_offsets[camera], fmt::format("cam{}", camera));
  feed([&](Session& session) -> std::string {
    const std::lock_guard lock(session.order_mutex);
    if (session.order.jumps_back(camera, time)) {
      return fmt::format("the stamps of cam{} jumped back", camera);
    }
    if (camera == 0) session.latency.arrived(time, arrived);
    session.order.add(camera, time, std::move(image));
    pass_on(session, session.order.take());
    return {};
  });
}

void RobotSlam::pass_on(Session& session, std::vector<SensorEvent> events) {
  for (SensorEvent& event : events) {
    std::visit(Overloaded{[&](const ImuSample& sample) { session.slam->process(sample); },
                          [&](ImageFrame& images) { session.slam->process(std::move(images)); },
                          [](const auto& /*other*/) {}},
               event);
  }
}

std::optional<PredictedState> RobotSlam::predicted(Time time) const {
  const auto session = this->session();
  const std::lock_guard lock(session->state_mutex);
  return session->predictor.at(time);
}

void RobotSlam::reset(const std::string& why) { restart(session(), why); }

// Once for a session, however many threads find that it has ended. It ends outside the lock: its
// thread may take a while.
void RobotSlam::restart(const std::shared_ptr<Session>& session, const std::string& why) {
  std::shared_ptr<Session> fresh = make_session();
  {
    const std::lock_guard lock(mutex_);
    if (session_ != session) return;
    session_ = std::move(fresh);
    ++resets_;
  }
  session->ended = true;
  if (callbacks_.on_reset) callbacks_.on_reset(why);
}

void RobotSlam::ask(const std::function<void(VisualInertialSlam&)>& question) {
  session()->slam->ask(question);
}

void RobotSlam::finish() {
  const auto session = this->session();
  const std::lock_guard lock(session->order_mutex);
  pass_on(*session, session->order.finish());
  const std::vector<Estimate> rest = session->slam->finish();
  session->slam->ask([&](VisualInertialSlam& slam) { session->note(rest, slam); });
}

RobotReport RobotSlam::report() {
  RobotReport report;
  const auto session = this->session();
  try {
    session->slam->ask([&](const VisualInertialSlam& slam) {
      if (!slam.estimator().started()) report.why_not_started = slam.estimator().why_not_started();
      report.recoveries = slam.estimator().report().resets;
    });
  } catch (const std::exception& error) {  // the next sample begins the run anew
    report.why_not_started = fmt::format("the estimator ended: {}", error.what());
  }
  report.images = session->slam->counts();
  if (const auto latency = session->latency.take()) {
    report.mean_latency = latency->mean;
    report.worst_latency = latency->worst;
  }
  {
    const std::lock_guard lock(session->state_mutex);
    report.last = session->last;
    report.samples = session->samples;
  }
  {
    const std::lock_guard lock(session->order_mutex);
    report.order = session->order.counts();
  }
  const std::lock_guard lock(mutex_);
  report.resets = resets_;
  return report;
}

std::string RobotSlam::save_map(const std::filesystem::path& file) {
  check_map_output(file);
  std::optional<LandmarkMap> map;
  ask([&](const VisualInertialSlam& slam) { map = slam.estimator().landmark_map(); });
  if (prior_ && (!map || map->sessions.size() <= prior_->sessions.size())) {
    throw UsageError(
        fmt::format("{}: the run has found no place in {}, so there is nothing to add "
                    "to it: no map was saved",
                    file.string(), setup_.map.string()));
  }
  if (!map || map->points.empty()) {
    throw UsageError(fmt::format(
        "{}: the run has no landmark that could be recognised: no map was saved", file.string()));
  }
  for (MapSession& session : map->sessions) {
    if (session.name.empty()) session.name = setup_.name;
  }
  const std::size_t bytes = write_map(*map, file);
  return fmt::format("{}: {} landmarks, {:.1f} kB", file.string(), map->points.size(),
                     1e-3 * static_cast<double>(bytes));
}

void RobotSlam::write_run(const std::filesystem::path& folder) {
  prepare_output(folder);
  const auto session = this->session();
  session->slam->ask([&](const VisualInertialSlam& slam) {
    if (session->log) session->log->write(slam.estimator(), folder);
  });
}

}  // namespace chasles::app
