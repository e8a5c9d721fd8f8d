#include <cstdio>
#include <string>

#include <chasles/eval/ate.hpp>
#include <chasles/pipeline/run.hpp>
#include <chasles/recording/readers.hpp>

/// run FOLDER ESTIMATOR [TUM]: SLAM from the images and the IMU of a recording. Succeeds if the
/// position error (RMSE) is below 10 cm. With a file, the positions must also equal its positions
/// exactly.
int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const std::string folder = argv[1], name = argv[2];

  const chasles::Recording recording = chasles::read_recording(folder);
  chasles::InertialRunSettings settings;
  settings.estimator = chasles::estimator_choice(name);  // "filter", "window:20", "batch"
  const chasles::RunResult run = chasles::run(recording, settings);
  for (const chasles::Estimate& e : run.estimates) {
    const Eigen::Vector3d p = e.world_T_imu.p;
    const Eigen::Vector3d sigma = e.covariance.diagonal().segment<3>(3).cwiseSqrt();
    std::printf("%.3f s: %.3f %.3f %.3f m, sigma %.3f %.3f %.3f m\n", chasles::to_seconds(e.time),
                p.x(), p.y(), p.z(), sigma.x(), sigma.y(), sigma.z());
  }

  chasles::Trajectory trajectory;
  for (const auto& e : run.estimates) trajectory.push_back({e.time, e.world_T_imu});
  const auto matched = chasles::associate(trajectory, recording.truth);
  const double error =
      chasles::absolute_error(matched, chasles::Alignment::kPositionYaw).position_m.rmse;
  bool same = true;
  if (argc > 3) {
    const chasles::Trajectory expected = chasles::read_tum(argv[3]);
    same = expected.size() == trajectory.size();
    for (std::size_t i = 0; same && i < expected.size(); ++i) {
      same = expected[i].time == trajectory[i].time && expected[i].pose.p == trajectory[i].pose.p;
    }
  }
  std::printf("%s: %zu estimates, %.3f m from the truth%s\n", name.c_str(), trajectory.size(),
              error, same ? "" : ", not those of the file");
  return error < 0.1 && same ? 0 : 1;
}
