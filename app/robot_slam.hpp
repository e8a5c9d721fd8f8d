#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <chasles/data/sensor_calibration.hpp>
#include <chasles/pipeline/realtime_slam.hpp>
#include <chasles/pipeline/sensor_order.hpp>

namespace chasles::app {

class RobotLog;

/// What RobotSlam is made of: the calibration, and what `chasles run` has as options.
struct RobotSetup {
  SensorCalibration calibration;      ///< with cameras
  InertialRunSettings settings = {};  ///< inertial_run_settings_from(); filter or window
  std::string name = "robot";         ///< of the run, and of its session in a saved map
  std::filesystem::path map = {};     ///< in which the run finds its place; empty: none
  bool saves_map = false;             ///< whether save_map() will be asked for
  bool keeps_run = false;             ///< whether write_run() will be asked for; takes memory
  /// Every image counts, however slow the estimator is, and every topic is waited for: for
  /// recordings that are played. Otherwise images are dropped (RealtimeSlam::Options).
  bool lossless = false;
  std::size_t most_images = 3;
};

/// Figures for diagnostics.
struct RobotReport {
  std::optional<Estimate> last;  ///< since the start or reset()
  std::string why_not_started;   ///< empty: started
  std::size_t samples = 0;       ///< that came since the start or reset()
  SensorOrder::Counts order;
  RealtimeSlam::Counts images;  ///< frames
  int resets = 0;               ///< of this object: reset(), jumps of the clock, errors
  int recoveries = 0;           ///< of the estimator: restarts where it was lost
  /// From the arrival of a frame's image until its estimate, since the last report [s].
  std::optional<double> mean_latency, worst_latency;
};

/// Visual-inertial SLAM for a robot's middleware: takes what drivers deliver on several threads,
/// puts it into the order of a recording (SensorOrder), and estimates on a thread of its own. With
/// `lossless` the estimates are those of `chasles run` on a bag of the same messages, to the byte.
///
/// A clock that jumps back (a bag that is played again) and an error of the estimator begin the run
/// anew, and are reported. Any thread may call.
class RobotSlam {
 public:
  using Clock = std::chrono::steady_clock;
  struct Callbacks {
    /// On the estimator's thread, as RealtimeSlam::Callback; must call no function of RobotSlam.
    RealtimeSlam::Callback on_estimates = {};
    /// The run begins anew, with the reason: a sentence.
    std::function<void(const std::string&)> on_reset = {};
  };

  /// Throws UsageError for settings, cameras or masks that cannot be used, and InputError for a map
  /// or mask that cannot be read.
  RobotSlam(RobotSetup setup, Callbacks callbacks);
  RobotSlam(const RobotSlam&) = delete;
  RobotSlam& operator=(const RobotSlam&) = delete;
  ~RobotSlam();

  const std::vector<Camera>& cameras() const { return setup_.calibration.cameras; }
  const RobotSetup& setup() const { return setup_; }
  /// As the estimator uses it, with imu_noise_scale.
  ImuNoise imu_noise() const;

  /// A sample as the IMU measured it.
  void add(const ImuSample& measured);
  /// An image of a camera, by the camera's clock; empty if it could not be decoded. Throws
  /// InputError for an image of another size than the camera's.
  void add(std::size_t camera, Time stamp, GrayImage image,
           Clock::time_point arrived = Clock::now());

  /// The state at this time, by all samples that have come (StatePredictor). Never waits for the
  /// estimator.
  std::optional<PredictedState> predicted(Time time) const;

  /// Begins anew, and forgets all that has come.
  void reset(const std::string& why);
  /// Calls the function on the estimator's thread, and waits for it.
  void ask(const std::function<void(VisualInertialSlam&)>& question);
  /// Processes what waits; on_estimates gets the rest. Nothing may be added after it.
  void finish();

  RobotReport report();
  /// Saves what another run can recognise. Returns a sentence on it. Throws UsageError, with the
  /// reason, where there is nothing to save or the file cannot be written.
  std::string save_map(const std::filesystem::path& file);
  /// Writes the run folder of what was estimated since the start or reset().
  void write_run(const std::filesystem::path& folder);

 private:
  struct Session;

  std::shared_ptr<Session> make_session() const;
  std::shared_ptr<Session> session() const;
  void restart(const std::shared_ptr<Session>& session, const std::string& why);
  void pass_on(Session& session, std::vector<SensorEvent> events);
  template <typename Work>
  void feed(const Work& work);

  RobotSetup setup_;
  Callbacks callbacks_;
  std::shared_ptr<const LandmarkMap> prior_;
  mutable std::mutex mutex_;          ///< of session_
  std::shared_ptr<Session> session_;  ///< from a start or reset to the next
  int resets_ = 0;
};

}  // namespace chasles::app
