#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <chasles/filter/inertial_testing.hpp>
#include <chasles/filter/random_ekf_testing.hpp>

// A filter that makes random steps of every kind that concerns past states.
namespace chasles::test {

struct Case {
  std::string chart;
  bool nav = false, calibrating = false, keeps_scale = false;
  bool revives = true;
  bool recalls = true;        // without it, nothing can
  bool marginalises = false;  // some past landmarks do not return, some of the state leave for ever
  bool prior = false;         // landmarks from elsewhere are added, twice
  bool considered = false;    // the first of them are not changed
};

inline std::string name_of(const Case& c) {
  std::string name = c.chart;
  std::ranges::replace(name, '-', '_');
  if (c.nav) name += "_nav";
  if (c.calibrating) name += "_calibrating";
  if (c.keeps_scale) name += "_scale";
  if (c.marginalises) name += "_marginalising";
  if (c.prior) name += c.considered ? "_considered_prior" : "_prior";
  if (!c.recalls) name += "_without_recall";
  return name + (c.revives ? "" : "_without_revival");
}

inline std::vector<Case> wanderer_cases() {
  std::vector<Case> all;
  for (const ErrorChart& chart : error_charts()) {
    const std::string name(chart.name);
    all.push_back({.chart = name});
    all.push_back({.chart = name, .revives = false});
    all.push_back({.chart = name, .revives = false, .recalls = false});
    all.push_back(
        {.chart = name, .nav = true, .calibrating = true, .revives = false, .recalls = false});
    all.push_back({.chart = name, .marginalises = true});
    all.push_back({.chart = name, .prior = true});
    all.push_back({.chart = name, .nav = true, .calibrating = true});
    all.push_back({.chart = name, .nav = true, .marginalises = true, .prior = true});
    all.push_back({.chart = name, .prior = true, .considered = true});
    all.push_back(
        {.chart = name, .nav = true, .marginalises = true, .prior = true, .considered = true});
    if (name != "left-se3") {
      all.push_back({.chart = name, .calibrating = true, .keeps_scale = true});
      all.push_back({.chart = name,
                     .calibrating = true,
                     .keeps_scale = true,
                     .prior = true,
                     .considered = true});
    }
  }
  return all;
}

// A filter that makes random steps; equal ones make equal steps.
class Wanderer {
 public:
  Wanderer(const Case& c, Ekf::Map map, std::size_t most_bytes = 0, int condensed_after = 10)
      : case_(c),
        random_(17),
        ekf_(inertial_filter(error_chart(c.chart), random_, c.nav, c.calibrating,
                             {.map = map,
                              .past = {.recalls = c.recalls,
                                       .records = true,
                                       .most_bytes = most_bytes,
                                       .condensed_after = condensed_after},
                              .keep_scale = c.keeps_scale})) {}

  const Ekf& ekf() const { return ekf_; }
  int revived() const { return revived_; }
  const std::vector<int>& inactive() const { return inactive_; }
  const std::vector<int>& frames() const { return frames_; }

  void step() {
    ++frame_;
    walk_on(ekf_, random_);
    const State& x = ekf_.state();
    if (case_.nav && frame_ % 5 == 0) ekf_.compose();
    if (case_.prior && (frame_ == 4 || frame_ == 23)) add_prior_map();
    if (frame_ % 3 == 0) initialise_landmarks();
    auto measurements = pixel_measurements(x, random_);
    for (Measurement& z : measurements) z.residual *= 0.1;
    ekf_.update(measurements);
    if (frame_ % 4 == 0 && !x.landmarks.empty()) {
      ekf_.add_noise(0, random_covariance(random_, 3, 0.01));
    }
    remember_pose();
    retire_some();
    if (case_.revives && frame_ % 7 == 0) revive_some();
    if (case_.marginalises && frame_ % 13 == 0) ekf_.remove(std::array{0});
  }

 private:
  // Landmarks near the filter, with five shared errors.
  void add_prior_map() {
    constexpr int kLandmarks = 9;
    const State& x = ekf_.state();
    const SE3 nav_T_imu = x.nav_T_world ? *x.nav_T_world * x.world_T_imu : x.world_T_imu;
    PriorMap prior{.map_T_prior = random_pose(random_, 5),
                   .landmarks = {},
                   .shared = 0.1 * random_matrix(random_, 6 + 3 * kLandmarks, 5),
                   .own = {},
                   .of_frame = 2};
    for (int i = 0; i < kLandmarks; ++i) {
      const Eigen::Vector3d p = nav_T_imu.p + 8 * random_.axis();
      prior.landmarks.push_back(
          {.id = 5000 + 100 * frame_ + i, .p_world = p, .observations = 20, .first = p});
      prior.own.emplace_back(random_covariance(random_, 3, 0.05));
    }
    const bool considers = case_.considered && frames_.empty();
    frames_.push_back(considers ? ekf_.consider(prior) : ekf_.add_past(prior));
    for (int i = 1; i <= kLandmarks; ++i) inactive_.push_back(frames_.back() + i);
  }

  void initialise_landmarks() {
    const int clone = 10 + frame_;
    ekf_.clone_pose(clone, from_seconds(frame_));
    add_anchored(ekf_, random_, 1000 + 10 * frame_, inertial_cameras()[0]);
    add_cartesian(ekf_, random_, 1001 + 10 * frame_);
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
    std::vector<int> left;
    for (const int index : gone) {
      const auto& landmark = ekf_.state().landmarks[static_cast<std::size_t>(index)];
      if (landmark.considered) left.push_back(*landmark.considered);
    }
    ekf_.retire(gone);
    for (int number = before; number < ekf_.past().states(); ++number) left.push_back(number);
    for (const int number : left) {
      if (case_.marginalises && number % 3 == 0) {
        ekf_.bar_return(std::array{number});
      } else {
        inactive_.push_back(number);
      }
    }
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
    for (const int number : inactive_) {
      if (numbers.size() < 3 && random_.uniform() < 0.3) numbers.push_back(number);
    }
    std::ranges::sort(numbers);
    ekf_.revive(numbers);
    revived_ += static_cast<int>(numbers.size());
    std::erase_if(inactive_, [&](int n) { return std::ranges::find(numbers, n) != numbers.end(); });
  }

  Case case_;
  Random random_;
  Ekf ekf_;
  int frame_ = 0;
  int revived_ = 0;
  std::vector<int> inactive_;
  std::vector<int> frames_;  // of prior maps
};

}  // namespace chasles::test
