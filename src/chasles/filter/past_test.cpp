#include <chasles/error.hpp>
#include <chasles/filter/inertial_testing.hpp>

// Past states against a filter that keeps every one of them in its covariance: landmarks and poses
// that leave, landmarks that return, clones, calibration, composition and changes of scale.

namespace chasles {
namespace {

using Eigen::MatrixXd;

constexpr double kPastTolerance = 1e-8;

struct Case {
  std::string chart;
  bool nav = false, calibrating = false, keeps_scale = false;
  bool revives = true;
};

std::string name_of(const Case& c) {
  std::string name = c.chart;
  std::ranges::replace(name, '-', '_');
  if (c.nav) name += "_nav";
  if (c.calibrating) name += "_calibrating";
  if (c.keeps_scale) name += "_scale";
  return name + (c.revives ? "" : "_without_revival");
}

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const ErrorChart& chart : error_charts()) {
    const std::string name(chart.name);
    all.push_back({.chart = name});
    all.push_back({.chart = name, .revives = false});
    all.push_back({.chart = name, .nav = true, .calibrating = true});
    if (name != "left-se3")
      all.push_back({.chart = name, .calibrating = true, .keeps_scale = true});
  }
  return all;
}

// A filter that makes random steps; equal ones make equal steps.
class Wanderer {
 public:
  Wanderer(const Case& c, Ekf::Map map)
      : case_(c),
        random_(17),
        ekf_(test::inertial_filter(error_chart(c.chart), random_, c.nav, c.calibrating,
                                   {.map = map,
                                    .past = {.recalls = true, .records = true},
                                    .keep_scale = c.keeps_scale})) {}

  const Ekf& ekf() const { return ekf_; }
  int revived() const { return revived_; }

  void step() {
    ++frame_;
    test::walk_on(ekf_, random_);
    const State& x = ekf_.state();
    if (case_.nav && frame_ % 5 == 0) ekf_.compose();
    if (frame_ % 3 == 0) begin_landmarks();
    auto measurements = test::pixel_measurements(x, random_);
    for (Measurement& z : measurements) z.residual *= 0.1;
    ekf_.update(measurements);
    if (frame_ % 4 == 0 && !x.landmarks.empty()) {
      ekf_.add_noise(0, test::random_covariance(random_, 3, 0.01));
    }
    remember_pose();
    retire_some();
    if (case_.revives && frame_ % 7 == 0) revive_some();
  }

 private:
  void begin_landmarks() {
    const int clone = 10 + frame_;
    ekf_.clone_pose(clone, from_seconds(frame_));
    test::add_anchored(ekf_, random_, 1000 + 10 * frame_, test::inertial_cameras()[0]);
    test::add_cartesian(ekf_, random_, 1001 + 10 * frame_);
  }

  void remember_pose() {
    NavScratch scratch;
    find_nav_derivative(ekf_.state(), scratch);
    const NavState now = nav_state(ekf_, scratch);
    ekf_.remember_pose(from_seconds(frame_), now.nav_T_imu, scratch.derivative.topRows<6>());
  }

  void retire_some() {
    std::vector<int> gone;
    for (std::size_t i = 0; i < ekf_.state().landmarks.size(); ++i) {
      const bool old = i + 6 < ekf_.state().landmarks.size();
      if (old || random_.uniform() < 0.1) gone.push_back(static_cast<int>(i));
    }
    const int before = ekf_.past().states();
    ekf_.retire(gone);
    for (int number = before; number < ekf_.past().states(); ++number) dormant_.push_back(number);
    std::vector<int> unused;
    for (const Clone& clone : ekf_.state().clones) {
      const bool used = std::ranges::any_of(ekf_.state().landmarks, [&](const Landmark& landmark) {
        return landmark.anchor == clone.id;
      });
      if (!used) unused.push_back(clone.id);
    }
    ekf_.remove_clones(unused);
  }

  void revive_some() {
    std::vector<int> numbers;
    for (const int number : dormant_) {
      if (numbers.size() < 3 && random_.uniform() < 0.3) numbers.push_back(number);
    }
    ekf_.revive(numbers);
    revived_ += static_cast<int>(numbers.size());
    std::erase_if(dormant_, [&](int n) { return std::ranges::find(numbers, n) != numbers.end(); });
  }

  Case case_;
  test::Random random_;
  Ekf ekf_;
  int frame_ = 0;
  int revived_ = 0;
  std::vector<int> dormant_;
};

void expect_same_estimates(const Ekf& a, const Ekf& b) {
  EXPECT_LT(test::distance(a.state(), b.state()), kPastTolerance);
  const MatrixXd P = a.covariance(), expected = b.covariance();
  ASSERT_EQ(P.rows(), expected.rows());
  EXPECT_LT(test::covariance_difference(P, expected), kPastTolerance);
  const Past::Estimates past = a.past_estimates(), dense = b.past_estimates();
  ASSERT_EQ(past.landmarks.size(), dense.landmarks.size());
  ASSERT_EQ(past.poses.size(), dense.poses.size());
  EXPECT_EQ(a.map_size(), static_cast<int>(past.landmarks.size()));
  for (std::size_t i = 0; i < past.landmarks.size(); ++i) {
    SCOPED_TRACE(::testing::Message() << "landmark " << i);
    const MapLandmark &one = past.landmarks[i], &other = dense.landmarks[i];
    ASSERT_EQ(one.id, other.id);
    EXPECT_EQ(one.observations, other.observations);
    EXPECT_TRUE(test::agree(one.p_world, other.p_world, kPastTolerance, 0));
    EXPECT_TRUE(test::agree(one.covariance, other.covariance, kPastTolerance, 0));
  }
  for (std::size_t i = 0; i < past.poses.size(); ++i) {
    SCOPED_TRACE(::testing::Message() << "pose " << i);
    EXPECT_EQ(past.poses[i].time, dense.poses[i].time);
    EXPECT_LT(test::distance(past.poses[i].map_T_imu, dense.poses[i].map_T_imu), kPastTolerance);
    EXPECT_TRUE(
        test::agree(past.poses[i].covariance, dense.poses[i].covariance, kPastTolerance, 0));
  }
}

class PastTest : public ::testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Runs, PastTest, ::testing::ValuesIn(cases()),
                         [](const auto& info) { return name_of(info.param); });

TEST_P(PastTest, IsThatOfAFilterThatForgetsNothing) {
  Wanderer filter(GetParam(), Ekf::Map::kPast), dense(GetParam(), Ekf::Map::kDense);
  for (int i = 0; i < 60; ++i) {
    filter.step();
    dense.step();
    if (i % 20 == 7) expect_same_estimates(filter.ekf(), dense.ekf());
  }
  expect_same_estimates(filter.ekf(), dense.ekf());
  EXPECT_EQ(filter.revived(), dense.revived());
  if (GetParam().revives) {
    EXPECT_GE(filter.revived(), 12);
  }
}

}  // namespace
}  // namespace chasles
