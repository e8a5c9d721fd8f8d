#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <unordered_map>
#include <vector>

#include <chasles/filter/drive_motion_testing.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/velocity/stereo_measurement.hpp>

/// Runs a filter on a simulated stereo-velocity run. Included by tests only.
namespace chasles::test {

struct DriveOptions {
  Motion motion = Motion::kVelocityState;
  double gate = std::numeric_limits<double>::infinity();
  int patience = 2;          ///< frames that an unobserved landmark stays in the state
  double process_noise = 1;  ///< factor on Q
  std::size_t map_bytes = 0;
};

class DrivenFilter {
 public:
  DrivenFilter(const ErrorChart& chart, const Drive& drive, const DriveOptions& options,
               const Eigen::MatrixXd& covariance, Ekf::Map map)
      : drive_(drive),
        options_(options),
        ekf_(chart, initial_state(options.motion, drive.frames[0]), covariance,
             {.map = map, .map_bytes = options.map_bytes}) {}

  Ekf& ekf() { return ekf_; }
  const Ekf& ekf() const { return ekf_; }
  int rejected() const { return rejected_; }

  void run() {
    while (frame_ < drive_.frames.size()) step();
  }

  void step() {
    if (frame_ > 0) propagate(drive_.frames[frame_ - 1]);
    const auto& observations = drive_.frames[frame_].observations;
    update(observations);
    ekf_.remember_pose(from_seconds(kDriveStep * static_cast<double>(frame_)));
    retire();
    initialise(observations);
    ++frame_;
  }

 private:
  void propagate(const DriveFrame& frame) {
    Prediction prediction = predict_drive(options_.motion, ekf_.state(), frame);
    prediction.Q *= options_.process_noise;
    ekf_.propagate(prediction);
    if (options_.motion != Motion::kVelocityState) return;
    const Measurement z[] = {measure_velocity(velocity_model(options_.motion), ekf_.state(),
                                              frame.velocity, velocity_noise())};
    ekf_.update(z);
  }

  void update(const std::vector<StereoObservation>& observations) {
    const StereoNoise noise{
        .u = kDrivePixelNoise, .v = kDrivePixelNoise, .disparity = kDrivePixelNoise};
    std::vector<Measurement> measurements;
    for (const StereoObservation& seen : observations) {
      const int index = index_of(seen.landmark);
      if (index < 0) continue;
      last_seen_[seen.landmark] = frame_;
      auto z =
          measure_stereo(drive_.rig, StereoRows::kMeanDisparity, noise, ekf_.state(), index, seen);
      if (!z) continue;
      z->gate = options_.gate;
      measurements.push_back(*z);
    }
    for (const bool accepted : ekf_.update(measurements).accepted) rejected_ += accepted ? 0 : 1;
  }

  void retire() {
    std::vector<int> gone;
    for (std::size_t i = 0; i < ekf_.state().landmarks.size(); ++i) {
      const std::size_t seen = last_seen_[ekf_.state().landmarks[i].id];
      if (frame_ > seen + static_cast<std::size_t>(options_.patience)) {
        gone.push_back(static_cast<int>(i));
      }
    }
    ekf_.retire(gone);
  }

  void initialise(const std::vector<StereoObservation>& observations) {
    const StereoNoise noise{
        .u = kDrivePixelNoise, .v = kDrivePixelNoise, .disparity = kDrivePixelNoise};
    std::vector<NewLandmark> fresh;
    for (const StereoObservation& seen : observations) {
      if (index_of(seen.landmark) >= 0) continue;
      last_seen_[seen.landmark] = frame_;
      fresh.push_back(*initialise_landmark(drive_.rig, noise, ekf_.state(), seen));
    }
    ekf_.add(fresh);
  }

  int index_of(LandmarkId id) const {
    const auto& landmarks = ekf_.state().landmarks;
    const auto at = std::find_if(landmarks.begin(), landmarks.end(),
                                 [&](const Landmark& landmark) { return landmark.id == id; });
    return at == landmarks.end() ? -1 : static_cast<int>(at - landmarks.begin());
  }

  const Drive& drive_;
  DriveOptions options_;
  Ekf ekf_;
  std::unordered_map<LandmarkId, std::size_t> last_seen_;  // frame
  std::size_t frame_ = 0;
  int rejected_ = 0;
};

/// visit_map_covariance as one symmetric matrix; its blocks must be in order and without gaps.
inline Eigen::MatrixXd whole_covariance(const Ekf& ekf) {
  const Eigen::Index n = 3 * ekf.map_size() + ekf.state().core_size();
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(n, n);
  Eigen::Index next = 0;
  ekf.visit_map_covariance([&](Eigen::Index row, const Eigen::MatrixXd& block) {
    EXPECT_EQ(row, next);
    ASSERT_LE(row + block.rows(), n);
    ASSERT_EQ(block.cols(), row + block.rows());
    P.block(row, 0, block.rows(), block.cols()) = block;
    next = row + block.rows();
  });
  EXPECT_EQ(next, n);
  return P.selfadjointView<Eigen::Lower>();
}

}  // namespace chasles::test
