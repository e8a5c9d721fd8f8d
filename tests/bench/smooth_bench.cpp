// The time of relinearisation. First, batch estimation over small stereo-velocity runs is compared
// with the dense Gauss-Newton oracle of the tests (velocity_oracle_testing.hpp, all derivatives
// numeric), and with the algebra alone of a dense step, as if its derivatives took no time. Exit
// status 1 if the batch is not at the oracle's minimum. Then filter, window and batch process
// 2020/0027 of the KITTI tracks, if available ($CHASLES_DATA, ../shared/data), without reading and
// writing. Times are processor times of all threads (there is one), the minimum of the repetitions;
// the oracle and the batch over the recording run once.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <vector>

#include <chasles/base/processor_time.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/smooth/batch/exact_settings_testing.hpp>
#include <chasles/smooth/batch/velocity_oracle_testing.hpp>
#include <chasles/smooth/window/velocity_window.hpp>
#include <chasles/velocity/velocity_noise.hpp>
#include <chasles/velocity/velocity_slam.hpp>

namespace chasles {
namespace {

constexpr int kRepetitions = 3;
constexpr double kSame = 1e-6;

template <typename Function>
double seconds_of(const Function& function, int repetitions = kRepetitions) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repetitions; ++i) {
    const double started = process_seconds();
    function();
    least = std::min(least, process_seconds() - started);
  }
  return least;
}

// A step of dense Gauss-Newton with a given Jacobian: normal equations, factorisation, solution.
void dense_step(const Eigen::MatrixXd& J, Eigen::MatrixXd& S) {
  dense::square_lower(J, S);
  Eigen::VectorXd x = J.transpose() * Eigen::VectorXd::Ones(J.rows());  // for an arbitrary residual
  if (!dense::cholesky(S)) std::abort();
  S.triangularView<Eigen::Lower>().solveInPlace(x);
  S.triangularView<Eigen::Lower>().transpose().solveInPlace(x);
}

// Whether the batch found the oracle's minimum.
bool small_drive(int frames) {
  const test::DriveScene scene = test::drive_scene({.frames = frames});
  const BatchSettings settings = test::exact_settings(LandmarkForm::kInverseDepth);
  const VelocityBatchResult batch = smooth(scene.input, settings);
  const double of_batch = seconds_of([&] { smooth(scene.input, settings); });
  test::VelocityOracle oracle(scene);
  const int steps = batch.report.iterations;
  const double of_oracle = seconds_of([&] { oracle.solve(steps); }, 1);
  double difference = 0;
  for (std::size_t k = 0; k < batch.estimates.size(); ++k) {
    const Eigen::VectorXd d = test::drive_error(oracle.states()[k], batch.estimates[k]);
    difference = std::max(difference, d.cwiseAbs().maxCoeff());
  }
  const Eigen::MatrixXd& J = oracle.jacobian();
  Eigen::MatrixXd S(J.cols(), J.cols());
  const double of_algebra = steps * seconds_of([&] { dense_step(J, S); });
  std::printf("%6d %9ld %6d %10.2f %12.1f %8.0f %12.2f %8.2f %11.1e\n", frames,
              static_cast<long>(J.cols()), steps, 1e3 * of_batch, 1e3 * of_oracle,
              of_oracle / of_batch, 1e3 * of_algebra, of_algebra / of_batch, difference);
  return difference < kSame;
}

template <typename Estimator>
std::vector<Estimate> through(const Recording& recording, Estimator&& estimator) {
  std::vector<Estimate> estimates;
  EventStream events(recording);
  while (const auto event = events.next()) {
    if (const auto* velocity = std::get_if<BodyVelocity>(&*event)) {
      estimator.process(*velocity);
    } else if (const auto* frame = std::get_if<FeatureFrame>(&*event)) {
      const std::optional<Estimate> e = estimator.process(*frame);
      if (e) estimates.push_back(*e);
    }
  }
  return estimates;
}

void long_drive(const Recording& recording) {
  const VelocitySlamSettings settings;
  const VelocitySlamNoise noise =
      choose_noise(settings, recording.velocities, recording.frames,
                   {.velocity = recording.velocity_sigma, .pixels = recording.pixel_sigma});
  VelocityBatchInput input{.rig = recording.rig,
                           .settings = settings,
                           .noise = noise,
                           .velocities = recording.velocities,
                           .frames = recording.frames};
  const double length = to_seconds(recording.frames.back().time - recording.frames.front().time);
  std::printf("\n%s: %zu frames, %.0f s\n%-12s %8s %8s %12s\n", recording.name.c_str(),
              recording.frames.size(), length, "", "s", "ratio", "x real time");
  double of_filter = 0;
  const auto say = [&](const char* name, double seconds) {
    if (of_filter == 0) of_filter = seconds;
    std::printf("%-12s %8.2f %8.2f %12.1f\n", name, seconds, seconds / of_filter, length / seconds);
  };
  say("filter", seconds_of([&] {
        input.initial = through(recording, VelocitySlam(settings, recording.rig, noise));
      }));
  for (const int keyframes : {10, 20, 40}) {
    const std::string name = "window:" + std::to_string(keyframes);
    say(name.c_str(),
        seconds_of([&] { through(recording, VelocityWindow(input, BatchSettings{}, keyframes)); }));
  }
  // It starts from the filter's estimates.
  say("batch", of_filter + seconds_of([&] { smooth(input, BatchSettings{}); }, 1));
}

}  // namespace
}  // namespace chasles

int main() {
  chasles::dense::prepare();
  std::printf("%6s %9s %6s %10s %12s %8s %12s %8s %11s\n", "frames", "unknowns", "steps",
              "batch, ms", "oracle, ms", "ratio", "algebra, ms", "ratio", "difference");
  bool same = true;
  for (const int frames : {5, 10, 20, 40}) same = chasles::small_drive(frames) && same;
  if (!same) std::printf("the batch is not at the oracle's minimum\n");
  const char* given = std::getenv("CHASLES_DATA");
  const std::filesystem::path data = given ? given : CHASLES_SOURCE_DIR "/../shared/data";
  const auto tracks = data / "kitti_tracks/ece276a_2020/0027.npz";
  if (std::filesystem::exists(tracks)) {
    chasles::long_drive(chasles::read_recording(tracks));
  } else {
    std::printf("%s is not there\n", tracks.c_str());
  }
  return same ? 0 : 1;
}
