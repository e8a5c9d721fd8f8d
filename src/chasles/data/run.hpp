#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/data/georeference.hpp>
#include <chasles/data/plan.hpp>
#include <chasles/data/run_images.hpp>
#include <chasles/lie/trajectory.hpp>

namespace chasles {

/// What the filter believed after a frame. A row of states.csv.
struct RunState {
  Time time{};
  SE3 world_T_imu;
  /// Covariance of [theta; dp]: R = Exp(theta) R_hat, p = p_hat + dp, both in world axes [rad, m].
  Matrix6d pose_covariance = Matrix6d::Zero();
  /// The other estimated numbers (velocities, biases), in the order of Run::extra_names, and their
  /// standard deviations.
  std::vector<double> extra, extra_sigma;
  double nis = 0;        ///< normalised innovation squared of the frame
  int nis_dof = 0;       ///< its degrees of freedom; 0: nothing was updated
  int observations = 0;  ///< offered by the frame
  int used = 0;          ///< that updated the state
  int rejected = 0;      ///< refused by the gate
  int added = 0;         ///< landmarks that the frame began
  int in_state = 0;      ///< landmarks that the frame's update could touch
  int landmarks = 0;     ///< landmarks of the whole map
  std::string health;    ///< "ok", "degraded", "lost"
  /// Wall time of the frame; kept in timing.csv, the only file that differs from run to run.
  double milliseconds = 0;
  /// And what its stages took [ms], in the order of Run::stage_names.
  std::vector<double> stages = {};
};

/// A landmark of the final map. A row of landmarks.csv.
struct RunLandmark {
  LandmarkId id = 0;
  Eigen::Vector3d p_world = Eigen::Vector3d::Zero();         ///< [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< additive error, world axes [m^2]
  int observations = 0;                                      ///< that were used
  /// Of the first and of the last frame that offered an observation of its number.
  Time first_seen{}, last_seen{};
  bool in_state = false;  ///< at the end a frame's update could touch it: it is not retired
};

/// A run folder in memory. Files: trajectory.tum, states.csv, landmarks.csv, map.ply, summary.json,
/// timing.csv and, where known, truth.tum, dead_reckoning.tum, plan.csv and images that were kept
/// (docs/formats.md).
struct Run {
  std::string name;                      ///< of the recording: summary.json's "name" when read
  std::vector<std::string> extra_names;  ///< e.g. "velocity_x", with the unit in docs/formats.md
  std::vector<std::string> stage_names = {};  ///< of RunState::stages, "front_end"; may be empty
  std::vector<RunState> states;
  std::vector<RunLandmark> landmarks;
  Trajectory truth;           ///< world_T_imu in the truth's own world; empty where unknown
  Trajectory dead_reckoning;  ///< world_T_imu
  Plan plan = {};             ///< of the place, in the truth's world; empty where unknown
  /// Of the truth's world, where known: summary.json's "georeference" when read.
  std::optional<Georeference> georeference = {};
  std::vector<RunImage> images = {};  ///< kept to be looked at: by time, then camera
};

/// Whether gravity makes the z axis of the run's world vertical: an IMU's biases were estimated.
bool is_level(const Run& run);

/// Writes the folder (made where missing). `summary` becomes summary.json as it is. Throws
/// UsageError if the folder cannot be written.
void write_run(const Run& run, const nlohmann::ordered_json& summary,
               const std::filesystem::path& folder);

/// Reads a folder that write_run wrote. All numbers are the same again, rotations to round-off.
/// Throws InputError with file, line and column.
Run read_run(const std::filesystem::path& folder);
nlohmann::ordered_json read_summary(const std::filesystem::path& folder);

}  // namespace chasles
