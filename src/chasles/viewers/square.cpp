#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/eval/alignment.hpp>
#include <chasles/eval/nees.hpp>
#include <chasles/viewers/square.hpp>

namespace chasles {
namespace {

// Of [translation; rotation] in the axes of the IMU.
Matrix6d body_covariance(const SmoothedPose& s) {
  const Matrix6d M = pose_error_map(PoseError::kBodyTwist, s.world_T_imu);
  const Matrix6d P = M * s.pose_covariance * M.transpose();
  Matrix6d swapped;
  swapped << P.bottomRightCorner<3, 3>(), P.bottomLeftCorner<3, 3>(), P.topRightCorner<3, 3>(),
      P.topLeftCorner<3, 3>();
  return swapped;
}

}  // namespace

std::string run_square(const Run& run, RunPath path, std::string_view version) {
  std::string text = fmt::format(
      "#%FORMAT SQUARE/0.3\n#%REPRESENTATION gaussian_se3\n#%POSE_FRAME world\n#%BODY_FRAME imu\n"
      "#%GAUGE fixed\n#%TIMESTAMP_UNIT seconds\n#%ALGORITHM chasles\n#%ALGORITHM_VERSION {}\n"
      "#%TANGENT_CONVENTION right_perturbation\n#%TANGENT_ORDER translation_rotation\n"
      "#%ROTATION_PARAM axis_angle\n",
      version);
  for (const SmoothedPose& s : path_poses(run, path)) {
    if (std::isnan(normalised_square(Vector6d::Zero(), s.pose_covariance))) continue;
    append_tum(s.time, s.world_T_imu, text);
    const Matrix6d P = body_covariance(s);
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j <= i; ++j) fmt::format_to(std::back_inserter(text), " {}", P(i, j));
    }
    text += '\n';
  }
  return text;
}

std::string square_truth(const Run& run, RunPath path) {
  if (run.truth.empty()) {
    throw InputError(
        fmt::format("run '{}' has no truth.tum, expected a run with a truth: "
                    "`chasles run --truth FILE`",
                    run.name));
  }
  Trajectory estimate;
  for (const SmoothedPose& s : path_poses(run, path)) {
    estimate.push_back({.time = s.time, .pose = s.world_T_imu});
  }
  const MatchedTrajectories matched = associate(estimate, run.truth, run.pairing);
  const Alignment first = is_level(run) ? Alignment::kFirstLevel : Alignment::kFirstPose;
  const SE3 world_T_truth = align(matched, first).truth_T_estimate.inverse();
  std::string text = "# t tx ty tz qx qy qz qw\n";
  for (std::size_t i = 0; i < matched.truth.size(); ++i) {
    append_tum(matched.estimate[i].time, world_T_truth * matched.truth[i].pose, text);
    text += '\n';
  }
  return text;
}

}  // namespace chasles
