#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/pipeline/map_file.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/recording/image_recording.hpp>
#include <chasles/recording/masks.hpp>
#include <chasles/robot/joined_imu.hpp>
#include <chasles/robot/robot_session.hpp>
#include <chasles/robot/robot_slam.hpp>
#include <chasles/session/map_output.hpp>
#include <chasles/slam/imu_in_use.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// Runs that ended before the last one, and whose outputs are kept: a fault may end one run after
// another.
constexpr int kMostKept = 100;

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
  if (const auto& readout = setup.settings.filter.readout_time) {
    set_readout(*readout, sensors.cameras);
  }
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
  const bool uses_maps = !setup.map.empty() || !setup.save_map.empty();
  if (uses_maps && !setup.settings.estimator.is_filter()) {
    throw UsageError("maps are for the filter, not for the estimator " +
                     name_of(setup.settings.estimator));
  }
  if (uses_maps) setup.settings.filter.recognise = Recognise::kAppearance;
  setup.calibration.time_offsets.resize(setup.calibration.cameras.size());
}

// The first of out/run-1, out/run-2 ... that is not there; empty for an empty path.
fs::path free_name(const fs::path& path) {
  if (path.empty()) return {};
  fs::path whole = fs::absolute(path).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();  // a slash at the end
  for (int n = 1; n <= kMostKept; ++n) {
    fs::path name = whole.parent_path() / whole.stem();
    name += fmt::format("-{}{}", n, whole.extension().string());
    std::error_code ignored;
    if (!fs::exists(name, ignored)) return name;
  }
  throw UsageError(fmt::format("{}: {} runs that ended are kept beside it already: remove some",
                               path.string(), kMostKept));
}

}  // namespace

std::string text_of(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const std::exception& known) {
    return known.what();
  } catch (...) {
    return "an unknown error";
  }
}

RobotSlam::RobotSlam(RobotSetup setup, Callbacks callbacks)
    : setup_(std::move(setup)), callbacks_(std::move(callbacks)) {
  check_setup(setup_);
  SensorCalibration& calibration = setup_.calibration;
  joined_ = std::make_unique<JoinedImu>(calibration.imu_range, calibration.gyro_R_accel);
  calibration.imu_range.accelerometer =
      turned_range(calibration.imu_range.accelerometer, calibration.gyro_R_accel);
  if (!setup_.map.empty()) map_ = std::make_unique<SharedMap>(setup_.map);
  session_ = make_session();
}

RobotSlam::~RobotSlam() = default;

std::shared_ptr<RobotSession> RobotSlam::make_session() const {
  const Recording sensors = sensors_of(setup_);
  const InertialRunSettings of_run = decided(setup_.settings, sensors);
  auto slam = std::make_unique<VisualInertialSlam>(
      sensors.cameras, *sensors.imu_noise, of_run, imu_options(sensors),
      read_masks(of_run.frontend.mask, sensors.cameras), map_ ? map_->map() : nullptr);
  return std::make_shared<RobotSession>(std::move(slam), setup_, sensors, of_run,
                                        callbacks_.on_estimates);
}

std::shared_ptr<RobotSession> RobotSlam::session() const {
  const std::lock_guard lock(mutex_);
  return session_;
}

ImuNoise RobotSlam::imu_noise() const {
  const InertialRunSettings of_run = decided(setup_.settings, sensors_of(setup_));
  return noise_in_use(of_run.filter, setup_.calibration.imu_noise);
}

// An exception is one of the estimator, which has ended.
template <typename Message>
void RobotSlam::feed(Message message, const std::string& topic) {
  const auto session = this->session();
  std::vector<Message> after_jump;
  const auto error = error_of([&] { after_jump = session->feed(std::move(message)); });
  if (error) restart(session, "the estimator ended: " + text_of(error));
  if (after_jump.empty()) return;
  restart(session, fmt::format("the stamps of {} jumped back", topic));
  for (Message& one : after_jump) this->session()->feed(std::move(one));
}

void RobotSlam::add(const ImuSample& measured) {
  feed(corrected_sample(setup_.calibration, measured), "the IMU");
}

std::vector<Time> RobotSlam::add_force(const AxesSample& force) {
  const std::lock_guard lock(joined_mutex_);
  return add_all(joined_->add_force(force));
}

std::vector<Time> RobotSlam::add_rate(const AxesSample& rate) {
  const std::lock_guard lock(joined_mutex_);
  return add_all(joined_->add_rate(rate));
}

std::vector<Time> RobotSlam::add_all(const std::vector<ImuSample>& joined) {
  std::vector<Time> times;
  for (const ImuSample& sample : joined) {
    add(sample);
    times.push_back(sample.time);
  }
  return times;
}

void RobotSlam::add(std::size_t camera, Time stamp, GrayImage image, Clock::time_point arrived) {
  const Camera& expected = cameras().at(camera);
  const std::string name = fmt::format("cam{}", camera);
  if (!image.empty() && (image.width != expected.width || image.height != expected.height)) {
    throw InputError(
        fmt::format("{}: an image has {} x {} pixels, expected {} x {} as in the "
                    "calibration",
                    name, image.width, image.height, expected.width, expected.height));
  }
  const Time time = by_imu_clock(stamp, setup_.calibration.time_offsets[camera], name);
  feed(ArrivedImage{.time = time, .camera = camera, .image = std::move(image), .arrived = arrived},
       name);
}

std::optional<PredictedState> RobotSlam::predicted(Time time) const {
  return session()->predicted(time);
}

bool RobotSlam::has_estimate() const { return session()->has_estimate(); }

void RobotSlam::reset(const std::string& why) { restart(session(), why); }

// Once for a session, however many threads find that it has ended. It ends outside the lock: its
// thread may take a while.
void RobotSlam::restart(const std::shared_ptr<RobotSession>& session, const std::string& why) {
  std::shared_ptr<RobotSession> fresh = make_session();
  {
    const std::lock_guard lock(mutex_);
    if (session_ != session) return;
    session_ = std::move(fresh);
    ++resets_;
  }
  session->end_callbacks();
  if (callbacks_.on_reset) callbacks_.on_reset(why);
  keep(*session);
}

void RobotSlam::keep(RobotSession& ended) {
  if (!ended.has_estimate() || (setup_.output.empty() && setup_.save_map.empty())) return;
  ended.finish();
  const std::lock_guard lock(keep_mutex_);
  std::exception_ptr error;
  const std::exception_ptr no_name =
      error_of([&] { error = write(ended, free_name(setup_.output), free_name(setup_.save_map)); });
  if (no_name || error) say(text_of(no_name ? no_name : error), false);
}

void RobotSlam::say(const std::string& sentence, bool written) const {
  if (callbacks_.on_output) callbacks_.on_output(sentence, written);
}

// Writes all that can be written. Returns the first error, and reports the rest.
std::exception_ptr RobotSlam::write(RobotSession& session, const fs::path& folder,
                                    const fs::path& file) const {
  std::exception_ptr first;
  const auto attempt = [&](const auto& work) {
    std::string sentence;
    const std::exception_ptr error = error_of([&] { sentence = work(); });
    if (!error) {
      say(sentence, true);
    } else if (first) {
      say(text_of(error), false);
    } else {
      first = error;
    }
  };
  if (!folder.empty()) {
    attempt([&] {
      session.write_run_folder(folder);
      return "run folder: " + folder.string();
    });
  }
  if (!file.empty()) attempt([&] { return "map: " + save_map(session, file); });
  return first;
}

void RobotSlam::ask(const std::function<void(VisualInertialSlam&)>& question) {
  session()->slam().ask(question);
}

void RobotSlam::finish() {
  {
    const std::lock_guard lock(joined_mutex_);
    add_all(joined_->finish());
  }
  session()->finish();
}

void RobotSlam::write_outputs(std::exception_ptr before) {
  const auto session = this->session();
  const std::exception_ptr error = write(*session, setup_.output, setup_.save_map);
  if (!before) before = session->failure();
  if (before && error) say(text_of(error), false);
  if (before || error) std::rethrow_exception(before ? before : error);
}

RobotReport RobotSlam::report() {
  RobotReport report = session()->report();
  {
    const std::lock_guard lock(joined_mutex_);
    report.joined = joined_->counts();
    report.wrong_stamps += joined_->wrong_stamps();
  }
  const std::lock_guard lock(mutex_);
  report.resets = resets_;
  return report;
}

std::string RobotSlam::save_map() { return save_map(*session(), setup_.save_map); }

// Not of an estimator that has ended with an error: its map may be wrong.
std::string RobotSlam::save_map(RobotSession& session, const fs::path& file) const {
  check_map_output(file);
  if (session.failure()) std::rethrow_exception(session.failure());
  std::optional<LandmarkMap> map;
  session.slam().ask(
      [&](const VisualInertialSlam& slam) { map = slam.estimator().landmark_map(); });
  if (map_ && (!map || map->sessions.size() <= map_->map()->sessions.size())) {
    throw UsageError(
        fmt::format("{}: the run has found no place in {}, so there is nothing to add "
                    "to it: no map was saved",
                    file.string(), setup_.map.string()));
  }
  if (!map || map->points.empty()) {
    throw UsageError(fmt::format(
        "{}: the run has no landmark that could be recognised: no map was saved", file.string()));
  }
  for (MapSession& mapped : map->sessions) {
    if (mapped.name.empty()) mapped.name = setup_.name;
  }
  const bool extends_map = map_ && is_same_file(file, setup_.map);
  const SharedMap::Saved saved = extends_map ? map_->save(*map)
                                             : SharedMap::Saved{.landmarks = map->points.size(),
                                                                .bytes = write_map(*map, file)};
  return fmt::format("{}: {}", file.string(), saved_text(saved));
}

}  // namespace chasles
