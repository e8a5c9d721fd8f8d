#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/lie/truth_pairing.hpp>
#include <chasles/recording/georeference.hpp>
#include <chasles/recording/plan.hpp>
#include <chasles/run_folder/map_sketch.hpp>
#include <chasles/run_folder/shown_images.hpp>

namespace chasles {

/// The estimate after a frame. A row of states.csv.
struct RunState {
  Time time{};
  SE3 world_T_imu;
  /// Covariance of [theta; dp]: R = Exp(theta) R_hat, p = p_hat + dp, both in world axes [rad, m].
  Matrix6d pose_covariance = Matrix6d::Zero();
  /// The other estimated states (velocities, biases), in the order of Run::extra_names, and their
  /// standard deviations.
  std::vector<double> extra, extra_sigma;
  double nis = 0;        ///< normalised innovation squared of the frame
  int nis_dof = 0;       ///< its degrees of freedom; 0: no update
  int observations = 0;  ///< observations in the frame
  int used = 0;          ///< observations that updated the state
  int rejected = 0;      ///< observations that the gate rejected
  int added = 0;         ///< landmarks that the frame initialised
  int in_state = 0;      ///< landmarks that the frame's update could correct
  int landmarks = 0;     ///< landmarks of the whole map
  std::string health;    ///< "ok", "degraded", "lost"
  /// Wall time of the frame [ms]; written to timing.csv, the only file that differs from run to
  /// run.
  double milliseconds = 0;
  /// Wall time of its stages [ms], in the order of Run::stage_names.
  std::vector<double> stages = {};
};

/// A pose of the path given all measurements, with the covariance as in RunState. A row of
/// smoothed.csv.
struct SmoothedPose {
  Time time{};
  SE3 world_T_imu;
  Matrix6d pose_covariance = Matrix6d::Zero();
};

/// A position with the covariance of its additive error, world axes.
struct UncertainPoint {
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();         ///< [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< [m^2]
};

/// A landmark of the final map. A row of landmarks.csv.
struct RunLandmark {
  LandmarkId id = 0;
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();         ///< [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< additive error, world axes [m^2]
  int observations = 0;                                      ///< number of observations used
  /// Times of the first and of the last frame with an observation of this landmark.
  Time first_seen{}, last_seen{};
  bool in_state = false;  ///< not retired: at the end an update could still correct it
  std::optional<UncertainPoint> initial = {};  ///< at the initialisation, where known
};

/// A run folder in memory. Files: trajectory.tum, states.csv, landmarks.csv, map.ply, summary.json,
/// timing.csv and, where known, trajectory_smoothed.tum, smoothed.csv, trajectory_in_map.tum,
/// in_map.csv, prior_map.csv, truth.tum, dead_reckoning.tum, plan.csv and images that were kept
/// (docs/formats.md).
struct Run {
  std::string name;                      ///< of the recording: summary.json's "name" when read
  std::vector<std::string> extra_names;  ///< e.g. "velocity_x", with the unit in docs/formats.md
  std::vector<std::string> stage_names = {};  ///< of RunState::stages, "front_end"; may be empty
  std::vector<RunState> states;
  std::vector<SmoothedPose> smoothed = {};  ///< by time; empty where unknown
  std::vector<SmoothedPose> in_map = {};    ///< as estimated at each frame, frame of a prior map
  std::optional<MapSketch> prior_map = {};  ///< in which the run has found its place
  std::vector<RunLandmark> landmarks;
  Trajectory truth;           ///< world_T_imu in the truth's own world; empty where unknown
  TruthPairing pairing = {};  ///< of the states with the truth, for all comparisons
  Trajectory dead_reckoning;  ///< world_T_imu
  Plan plan = {};             ///< of the place, in the truth's world; empty where unknown
  /// Of the truth's world, where known: summary.json's "georeference" when read.
  std::optional<Georeference> georeference = {};
  std::vector<ShownImage> images = {};  ///< kept for display; by time, then camera
};

/// Whether the z axis of the run's world is vertical: true if the run estimated IMU biases.
bool is_level(const Run& run);

/// Ids of the landmarks of the prior map that the run has recognised: it used more observations of
/// them than the map had.
std::set<LandmarkId> recognised_landmarks(const Run& run);

/// Writes the folder, and creates it if missing. An earlier run in it is replaced as a whole, or
/// stays as it is where this fails (FolderReplacement). `timing` is called when the other files are
/// written, for the text of timing.json; empty: no such file. Returns summary.json: `summary`, and
/// the entry `files` with the sizes and check sums. Throws UsageError if the folder cannot be
/// written.
nlohmann::ordered_json write_run(const Run& run, const nlohmann::ordered_json& summary,
                                 const std::filesystem::path& folder,
                                 const std::function<std::string()>& timing = {});

/// Reads a folder that write_run() wrote. All numbers are identical; rotations agree to round-off.
/// Throws InputError with file, line and column, and where the files are not those that
/// summary.json lists.
Run read_run(const std::filesystem::path& folder);
/// summary.json without its entry `files`.
nlohmann::ordered_json read_summary(const std::filesystem::path& folder);

}  // namespace chasles
