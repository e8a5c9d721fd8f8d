#include <numeric>

#include <chasles/filter/drive_motion_testing.hpp>
#include <chasles/filter/ekf.hpp>
#include <chasles/filter/run_drive_testing.hpp>
#include <chasles/filter/testing.hpp>
#include <chasles/filter/textbook_ekf_testing.hpp>
#include <chasles/velocity/stereo_measurement.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using test::Motion;
using test::TextbookEkf;

constexpr double kTextbookTolerance = 1e-9;
const StereoNoise kTextbookNoise{
    .u = test::kDrivePixelNoise, .v = test::kDrivePixelNoise, .disparity = test::kDrivePixelNoise};

using Case = std::tuple<const ErrorChart*, Motion>;

class TextbookEkfTest : public ::testing::TestWithParam<Case> {
 protected:
  const ErrorChart& chart() const { return *std::get<0>(GetParam()); }
  Motion motion() const { return std::get<1>(GetParam()); }
};

std::string case_name(const ::testing::TestParamInfo<Case>& of) {
  return test::chart_test_name({std::get<0>(of.param), 0}) + "_" +
         test::motion_test_name(std::get<1>(of.param));
}

INSTANTIATE_TEST_SUITE_P(Charts, TextbookEkfTest,
                         ::testing::Combine(::testing::ValuesIn(test::all_charts()),
                                            ::testing::Values(Motion::kVelocityState,
                                                              Motion::kVelocityInput,
                                                              Motion::kInertial)),
                         case_name);

// Both filters run on the same trajectory; landmarks that are no longer observed are retired.
class Pair {
 public:
  Pair(const ErrorChart& chart, Motion motion, const test::Drive& drive)
      : motion_(motion),
        drive_(drive),
        ekf_(chart, test::initial_state(motion, drive.frames[0]),
             test::initial_covariance(motion, 0.02), {.map = Ekf::Map::kDense}),
        textbook_(TextbookEkf::error_named(chart.name), ekf_.state(), in_chart_coordinates()) {}

  const Ekf& ekf() const { return ekf_; }
  const TextbookEkf& textbook() const { return textbook_; }

  void step(std::size_t frame) {
    if (frame > 0) propagate(drive_.frames[frame - 1]);
    observe(drive_.frames[frame].observations);
  }

  // The filter's covariance, with the past landmarks, in the coordinates and the order of the
  // textbook filter.
  MatrixXd in_chart_coordinates() const {
    const MatrixXd map = test::whole_covariance(ekf_);  // past landmarks, landmarks, core
    const Eigen::Index past = 3 * static_cast<Eigen::Index>(retired_.size());
    const int core = ekf_.state().core_size();
    std::vector<Eigen::Index> rows(static_cast<std::size_t>(map.rows()));
    std::iota(rows.begin(), rows.end(), 0);
    std::rotate(rows.begin(), rows.end() - core, rows.end());
    std::rotate(rows.begin() + core, rows.begin() + core + past, rows.end());
    MatrixXd P = map(rows, rows);  // core, landmarks, past landmarks
    push(ekf_.chart(), ekf_.state(), P);
    P.transposeInPlace();
    push(ekf_.chart(), ekf_.state(), P);
    std::vector<int> landmarks;
    for (int i = 0; i < static_cast<int>(textbook_landmarks()); ++i) {
      if (std::ranges::find(retired_, i) == retired_.end()) landmarks.push_back(i);
    }
    landmarks.insert(landmarks.end(), retired_.begin(), retired_.end());
    std::vector<Eigen::Index> places(static_cast<std::size_t>(map.rows()));
    for (int i = 0; i < core; ++i) places[static_cast<std::size_t>(i)] = i;
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      const auto at = static_cast<std::size_t>(core + 3 * landmarks[i]);
      for (std::size_t k = 0; k < 3; ++k) {
        places[at + k] = core + 3 * static_cast<Eigen::Index>(i) + static_cast<Eigen::Index>(k);
      }
    }
    return P(places, places);
  }

 private:
  std::size_t textbook_landmarks() const { return retired_.size() + ekf_.state().landmarks.size(); }

  void propagate(const test::DriveFrame& frame) {
    ekf_.propagate(test::predict_drive(motion_, ekf_.state(), frame));
    if (motion_ == Motion::kInertial) {
      textbook_.propagate(test::inertial_model(), frame.inertial, test::kDriveStep);
      return;
    }
    const BodyVelocityModel model = test::velocity_model(motion_);
    const BodyVelocityNoise noise = test::velocity_noise();
    textbook_.propagate(model, frame.velocity, test::kDriveStep, noise);
    if (motion_ != Motion::kVelocityState) return;
    const Measurement z[] = {measure_velocity(model, ekf_.state(), frame.velocity, noise)};
    ekf_.update(z);
    textbook_.measure_velocity(model, frame.velocity, noise.sample_sigma);
  }

  void observe(const std::vector<StereoObservation>& observations) {
    std::vector<Measurement> measurements;
    std::vector<std::pair<int, StereoObservation>> seen;
    std::vector<StereoObservation> fresh;
    std::vector<bool> in_view(ekf_.state().landmarks.size(), false);
    for (const StereoObservation& observation : observations) {
      const auto& landmarks = ekf_.state().landmarks;
      const auto at = std::find_if(landmarks.begin(), landmarks.end(),
                                   [&](const Landmark& l) { return l.id == observation.landmark; });
      if (at == landmarks.end()) {
        fresh.push_back(observation);
        continue;
      }
      const int index = static_cast<int>(at - landmarks.begin());
      in_view[static_cast<std::size_t>(index)] = true;
      measurements.push_back(*measure_stereo(drive_.rig, StereoRows::kMeanDisparity, kTextbookNoise,
                                             ekf_.state(), index, observation));
      seen.push_back({all_along(observation.landmark), observation});
    }
    ekf_.update(measurements);
    textbook_.measure(drive_.rig, test::kDrivePixelNoise, seen);
    retire(in_view);
    initialise(fresh);
  }

  void retire(const std::vector<bool>& in_view) {
    std::vector<int> gone;
    for (std::size_t i = 0; i < in_view.size(); ++i) {
      if (in_view[i]) continue;
      gone.push_back(static_cast<int>(i));
      retired_.push_back(all_along(ekf_.state().landmarks[i].id));
      textbook_.retire(retired_.back());
    }
    ekf_.retire(gone);
  }

  void initialise(const std::vector<StereoObservation>& fresh) {
    std::vector<NewLandmark> initialised;
    for (const StereoObservation& observation : fresh) {
      initialised.push_back(
          *initialise_landmark(drive_.rig, kTextbookNoise, ekf_.state(), observation));
      textbook_.initialise(drive_.rig, test::kDrivePixelNoise, observation);
    }
    ekf_.add(initialised);
  }

  // The index of the textbook's landmark, which it never removes: the latest with that id.
  int all_along(LandmarkId id) const {
    const auto& landmarks = textbook_.state().landmarks;
    for (int i = static_cast<int>(landmarks.size()) - 1;; --i) {
      if (landmarks[static_cast<std::size_t>(i)].id == id) return i;
    }
  }

  Motion motion_;
  const test::Drive& drive_;
  Ekf ekf_;
  std::vector<int> retired_;  // textbook's landmarks, in the order in which they left
  TextbookEkf textbook_;
};

// Of the means of the filter's state.
double mean_difference(const Ekf& ekf, const TextbookEkf& textbook) {
  State y = textbook.state();
  y.landmarks.clear();
  for (std::size_t i = 0; i < textbook.state().landmarks.size(); ++i) {
    if (!textbook.retired(i)) y.landmarks.push_back(textbook.state().landmarks[i]);
  }
  return test::distance(ekf.state(), y);
}

// The retired ones, by id (a landmark that is observed again is a new one).
double map_difference(const Ekf& ekf, const TextbookEkf& textbook) {
  double difference = 0;
  for (const MapLandmark& landmark : ekf.map()) {
    double nearest = 1e9;
    for (const Landmark& other : textbook.state().landmarks) {
      if (other.id != landmark.id) continue;
      nearest = std::min(nearest, (other.p_world - landmark.p_world).norm());
    }
    difference = std::max(difference, nearest);
  }
  return difference;
}

TEST_P(TextbookEkfTest, FilterInTheReferenceChartIsTheOneInItsOwnCoordinates) {
  const test::Drive drive = test::simulate_drive(
      {.frames = 301, .initial_points = 6, .points_a_frame = 1, .frames_between = 8, .seed = 11});
  Pair filters(chart(), motion(), drive);
  double mean = 0, covariance = 0;
  for (std::size_t frame = 0; frame < drive.frames.size(); ++frame) {
    filters.step(frame);
    mean = std::max(mean, mean_difference(filters.ekf(), filters.textbook()));
    covariance = std::max(covariance, test::covariance_difference(filters.in_chart_coordinates(),
                                                                  filters.textbook().covariance()));
  }
  // Metres, radians; the trajectory is 240 m long, so that 1e-9 of it is 2e-7.
  EXPECT_LT(mean, kTextbookTolerance);
  EXPECT_LT(covariance, kTextbookTolerance);
  EXPECT_LT(map_difference(filters.ekf(), filters.textbook()), kTextbookTolerance);
  EXPECT_GE(filters.ekf().map_size(), 40);
  EXPECT_LT(filters.ekf().state().landmarks.size(), 20u);
  // The filter tracked the trajectory: its linearisation points are realistic.
  const SE3 error = filters.ekf().state().world_T_imu * drive.frames.back().world_T_imu.inverse();
  EXPECT_LT(so3::log(error.R).norm(), 0.5);
}

}  // namespace
}  // namespace chasles
