#pragma once

#include <chrono>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <chasles/imu/join_imu.hpp>
#include <chasles/pipeline/realtime_slam.hpp>
#include <chasles/pipeline/sensor_order.hpp>
#include <chasles/pipeline/shared_map.hpp>
#include <chasles/recording/sensor_calibration.hpp>

namespace chasles::app {

class JoinedImu;
class RobotSession;

/// What RobotSlam is made of: the calibration, and what `chasles run` has as options.
struct RobotSetup {
  SensorCalibration calibration;        ///< with cameras
  InertialRunSettings settings = {};    ///< inertial_run_settings_from(); filter or window
  std::string name = "robot";           ///< of the run, and of its session in a saved map
  std::filesystem::path map = {};       ///< in which the run finds its place; empty: none
  std::filesystem::path output = {};    ///< folder of the run; empty: none; one takes memory
  std::filesystem::path save_map = {};  ///< file of the run's map; empty: none
  /// Every image counts, however slow the estimator is, and every topic is waited for: for
  /// recordings that are played. add() then waits for the estimator. Otherwise images are dropped
  /// (RealtimeSlam::Options).
  bool lossless = false;
  std::size_t most_images = 3;
};

/// Figures for diagnostics.
struct RobotReport {
  std::optional<Estimate> last;  ///< since the start or reset()
  std::string why_not_started;   ///< empty: started; at most half a second old
  std::size_t samples = 0;       ///< that came since the start or reset()
  ImuJoiner::Counts joined;      ///< of an accelerometer and a gyroscope apart; over all resets
  SensorOrder::Counts order;
  int wrong_stamps = 0;         ///< messages that were left out (StampLeaps)
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
/// anew, and are reported. What the ended run had is written first, beside the outputs, which the
/// last run gets: walk-1.map for walk.map. One wrong stamp begins nothing anew (StampLeaps). Any
/// thread may call.
class RobotSlam {
 public:
  using Clock = std::chrono::steady_clock;
  struct Callbacks {
    /// On the estimator's thread, as RealtimeSlam::Callback; must call no function of RobotSlam.
    RealtimeSlam::Callback on_estimates = {};
    /// The run begins anew, with the reason: a sentence.
    std::function<void(const std::string&)> on_reset = {};
    /// An output was written, or not: a sentence.
    std::function<void(const std::string&, bool written)> on_output = {};
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
  /// A sample of an accelerometer, or of a gyroscope, that has a topic of its own. Returns the
  /// times of the IMU samples that it completes, which have been added (ImuJoiner).
  std::vector<Time> add_force(const AxesSample& force);
  std::vector<Time> add_rate(const AxesSample& rate);
  /// An image of a camera, by the camera's clock; empty if it could not be decoded. Throws
  /// InputError for an image of another size than the camera's.
  void add(std::size_t camera, Time stamp, GrayImage image,
           Clock::time_point arrived = Clock::now());

  /// The state at this time, by all samples that have come (StatePredictor). Never waits for the
  /// estimator.
  std::optional<PredictedState> predicted(Time time) const;

  bool has_estimate() const;  ///< since the start or reset()

  /// Begins anew, and discards all that has come.
  void reset(const std::string& why);
  /// Calls the function on the estimator's thread, and waits for it.
  void ask(const std::function<void(VisualInertialSlam&)>& question);
  /// Processes what waits; on_estimates gets the rest. Nothing may be added after it. An error of
  /// the estimator is left to write_outputs().
  void finish();
  /// After finish(): writes run folder and map, all that can be written. Then throws the first
  /// error: `before`, with which the program's own work has ended, the estimator's, or that of an
  /// output.
  void write_outputs(std::exception_ptr before = nullptr);

  /// Waits for nothing that the estimator does.
  RobotReport report();
  /// Saves what another run can recognise, now. Returns a sentence on it. Throws UsageError, with
  /// the reason, where there is nothing to save or the file cannot be written.
  std::string save_map();

 private:
  std::shared_ptr<RobotSession> make_session() const;
  std::shared_ptr<RobotSession> session() const;
  void restart(const std::shared_ptr<RobotSession>& session, const std::string& why);
  void keep(RobotSession& ended);
  std::exception_ptr write(RobotSession& session, const std::filesystem::path& folder,
                           const std::filesystem::path& file) const;
  void say(const std::string& sentence, bool written) const;
  std::string save_map(RobotSession& session, const std::filesystem::path& file) const;
  template <typename Message>
  void feed(Message message, const std::string& topic);
  std::vector<Time> add_all(const std::vector<ImuSample>& joined);

  RobotSetup setup_;
  mutable std::mutex joined_mutex_;  ///< of the next, and of adding what it returns
  std::unique_ptr<JoinedImu> joined_;
  Callbacks callbacks_;
  std::unique_ptr<SharedMap> map_;
  mutable std::mutex mutex_;               ///< of session_
  std::shared_ptr<RobotSession> session_;  ///< from a start or reset to the next
  int resets_ = 0;
  std::mutex keep_mutex_;  ///< held while an ended run is written: its names are free before
};

/// What the work throws; null: nothing.
template <typename Work>
std::exception_ptr error_of(const Work& work) {
  try {
    work();
  } catch (...) {
    return std::current_exception();
  }
  return nullptr;
}

/// The text of an exception that is not null.
std::string text_of(const std::exception_ptr& error);

}  // namespace chasles::app
