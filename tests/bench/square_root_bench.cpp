// The cost of the filter's linear algebra as a square root or in single precision. The same frames
// (10 Hz, 50 landmarks, 15 clones; frame_steps.hpp) pass through the filter's own functions, the
// same algorithm in float, and a triangular root in double and float (covariance_forms.hpp), all in
// one run. It also measures the difference of each from the first over 1000 frames. First, small
// random frames are compared with the textbook's formulas in long double: exit status 1 if one is
// wrong.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <Eigen/Eigenvalues>

#include <chasles/base/processor_time.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/inertial_model.hpp>

#include "covariance_forms.hpp"
#include "textbook.hpp"

namespace chasles::bench {
namespace {

constexpr double kSeconds = 101;                   // of the walk
constexpr std::size_t kFirst = 400, kTimed = 100;  // frames that are timed
constexpr int kRepetitions = 15;
constexpr int kCore = 15;  // rows

/// The filter itself, in the chart whose corrections do not change the covariance.
class OwnForm {
 public:
  static constexpr bool kNewestFirst = false;
  explicit OwnForm(const Eigen::MatrixXd& core_covariance)
      : ekf_(error_chart("standard"), initial(), core_covariance, {.map = Ekf::Map::kFrozen}) {}

  void propagate(const FrameStep& step) { ekf_.propagate(step.prediction); }
  void exchange(const FrameStep& step) {
    ekf_.retire(step.retired);
    ekf_.remove_clones(step.removed);
    std::vector<NewLandmark> landmarks;
    for (const Fresh& fresh : step.fresh) {
      if (fresh.is_clone) {
        ekf_.clone_pose(static_cast<int>(fresh.id), {});
      } else {
        landmarks.push_back({.id = fresh.id, .d_pose = fresh.d_pose, .noise = fresh.noise});
      }
    }
    ekf_.add(landmarks);
  }
  bool update(const FrameStep& step) { return !ekf_.update(step.used).failed; }
  Eigen::MatrixXd covariance() const { return ekf_.covariance(); }

 private:
  static State initial() {
    State x;
    x.v_world = Eigen::Vector3d::Zero();
    x.additive = Eigen::VectorXd::Zero(InertialModel::kSize);
    return x;
  }

  Ekf ekf_;
};

int rows_before(const std::vector<FrameStep>& frames, std::size_t i) {
  return i == 0 ? kCore : frames[i - 1].state.size();
}

/// A form with the frames in its own format.
template <typename Form, typename Work>
struct Runner {
  const char* name;
  std::vector<Work> works;
  Form form;

  bool step(std::size_t i) {
    form.propagate(works[i]);
    form.exchange(works[i]);
    return form.update(works[i]);
  }
  Eigen::MatrixXd covariance() const {  // rows in the order of FrameStep
    Eigen::MatrixXd P = form.covariance();
    if (!Form::kNewestFirst) return P;
    std::vector<Eigen::Index> order;
    const Eigen::Index core = kCore;
    for (Eigen::Index i = 0; i < core; ++i) order.push_back(i);
    for (Eigen::Index i = P.rows() - 1; i >= core; --i) order.push_back(i);
    return P(order, order);
  }
};

Runner<OwnForm, FrameStep> own(const char* name, const Walk& walk) {
  return {name, walk.frames, OwnForm(walk.core_covariance)};
}

template <template <typename> class Form, typename S>
Runner<Form<S>, Work<S>> other(const char* name, const Walk& walk) {
  Runner<Form<S>, Work<S>> runner{name, {}, Form<S>(walk.core_covariance)};
  for (std::size_t i = 0; i < walk.frames.size(); ++i) {
    runner.works.push_back(
        work_of<S>(walk.frames[i], rows_before(walk.frames, i), Form<S>::kNewestFirst));
  }
  return runner;
}

// Calls visit(runner, relative precision) for every form.
template <typename Visitor>
void for_each_form(const Walk& walk, const Visitor& visit) {
  visit(own("covariance, double (as it is)", walk), 1e-15);
  visit(other<DenseForm, double>("the same, reimplemented", walk), 1e-15);
  visit(other<DenseForm, float>("covariance, float", walk), 1e-7);
  visit(other<RootForm, double>("square root, double", walk), 1e-15);
  visit(other<RootForm, float>("square root, float", walk), 1e-7);
}

// ---- against the textbook -----------------------------------------------------------------------

bool all_right() {
  const Walk walk = random_walk();
  const auto [P, correction] = textbook(walk);
  bool right = true;
  for_each_form(walk, [&, &P = P, &correction = correction](auto runner, double precision) {
    for (std::size_t i = 0; i < walk.frames.size(); ++i) right = runner.step(i) && right;
    const Oracle difference = runner.covariance().template cast<long double>() - P;
    const auto wrong = static_cast<double>(difference.norm() / P.norm());
    double wrong_correction =
        0;  // the filter's own correction is not accessible: its tests cover it
    if constexpr (requires { runner.form.correction(); }) {
      Eigen::MatrixXd c = runner.form.correction().template cast<double>();
      if (decltype(runner.form)::kNewestFirst) c.bottomRows(c.rows() - kCore).reverseInPlace();
      wrong_correction =
          static_cast<double>((c.cast<long double>() - correction).norm() / correction.norm());
    }
    const bool fits = wrong < 1e3 * precision && wrong_correction < 1e3 * precision;
    std::printf("  %-32s P %.1e, correction %.1e%s\n", runner.name, wrong, wrong_correction,
                fits ? "" : "  WRONG");
    right = right && fits;
  });
  return right;
}

// ---- time and error -----------------------------------------------------------------------------

double cpu_ms() { return 1e3 * processor_seconds(); }

using Stages = std::array<double, 3>;  // propagate, exchange, update [ms]

// The minimum of the repetitions, frame by frame and stage by stage, and its mean over the frames.
template <typename Runner>
Stages least(Runner runner) {
  for (std::size_t i = 0; i < kFirst; ++i) runner.step(i);
  const auto begin = runner.form;
  std::vector<Stages> best(kTimed, {1e9, 1e9, 1e9});
  for (int repetition = 0; repetition < kRepetitions; ++repetition) {
    runner.form = begin;
    for (std::size_t i = 0; i < kTimed; ++i) {
      const auto& work = runner.works[kFirst + i];
      std::array<double, 4> t{cpu_ms()};
      runner.form.propagate(work);
      t[1] = cpu_ms();
      runner.form.exchange(work);
      t[2] = cpu_ms();
      runner.form.update(work);
      t[3] = cpu_ms();
      for (std::size_t k = 0; k < 3; ++k) best[i][k] = std::min(best[i][k], t[k + 1] - t[k]);
    }
  }
  Stages mean{};
  for (const Stages& s : best) {
    for (std::size_t k = 0; k < 3; ++k) mean[k] += s[k] / static_cast<double>(kTimed);
  }
  return mean;
}

void print_times(const Walk& walk) {
  std::printf("  %-32s propagate  exchange    update       all  ratio\n", "ms a frame");
  double first = 0;
  for_each_form(walk, [&](auto runner, double) {
    const Stages ms = least(std::move(runner));
    const double all = ms[0] + ms[1] + ms[2];
    if (first == 0) first = all;
    std::printf("  %-32s %9.4f %9.4f %9.4f %9.4f   %.2f\n", runner.name, ms[0], ms[1], ms[2], all,
                all / first);
  });
}

/// Over all frames: the difference of the sigmas from the reference, failed updates, and the least
/// eigenvalue of the correlation matrix (of every tenth frame).
template <typename Runner>
void print_error(Runner runner, const std::vector<Eigen::VectorXd>& yardstick) {
  double worst = 0, worst_pose = 0, least_eigenvalue = 1;
  int failed = 0, negative = 0;
  for (std::size_t i = 0; i < runner.works.size(); ++i) {
    failed += runner.step(i) ? 0 : 1;
    const Eigen::MatrixXd P = runner.covariance();
    const Eigen::VectorXd sigma = P.diagonal().cwiseMax(0).cwiseSqrt();
    for (Eigen::Index k = 0; k < sigma.size(); ++k) {
      if (yardstick[i](k) < 1e-9) continue;
      const double error = std::abs(sigma(k) / yardstick[i](k) - 1);
      worst = std::max(worst, error);
      if (k < 6) worst_pose = std::max(worst_pose, error);
    }
    negative += P.diagonal().minCoeff() < 0;
    if (i % 10 != 0 || sigma.minCoeff() <= 0) continue;  // the initial position has no variance
    const Eigen::VectorXd scale = sigma.cwiseInverse();
    const Eigen::MatrixXd correlation = scale.asDiagonal() * P * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation, Eigen::EigenvaluesOnly);
    least_eigenvalue = std::min(least_eigenvalue, eigen.eigenvalues()(0));
  }
  std::printf("  %-32s %8.1e %8.1e %14.1e %9d %9d\n", runner.name, worst, worst_pose,
              least_eigenvalue, negative, failed);
}

void print_errors(const Walk& walk) {
  std::vector<Eigen::VectorXd> yardstick;
  auto exact = other<RootForm, double>("", walk);
  for (std::size_t i = 0; i < walk.frames.size(); ++i) {
    exact.step(i);
    yardstick.emplace_back(exact.covariance().diagonal().cwiseSqrt());
  }
  std::printf("  over %zu frames: sigmas against the root in double\n", walk.frames.size());
  std::printf("  %-32s    worst     pose  least eigenv.  var. < 0    failed\n", "");
  for_each_form(walk, [&](auto runner, double) { print_error(std::move(runner), yardstick); });
}

void measure(int cameras) {
  const Walk walk = record_walk(cameras, kSeconds);
  double rows = 0, size = 0;
  for (std::size_t i = kFirst; i < kFirst + kTimed; ++i) {
    size += walk.frames[i].state.size();
    for (const Measurement& z : walk.frames[i].used) rows += static_cast<double>(z.residual.size());
  }
  std::printf("%s: %.0f rows in the state, %.0f measured\n", cameras == 1 ? "mono" : "stereo",
              size / kTimed, rows / kTimed);
  print_times(walk);
  print_errors(walk);
}

}  // namespace
}  // namespace chasles::bench

int main() {
  chasles::dense::prepare();
  std::puts("against the textbook's formulas in long double, relative:");
  if (!chasles::bench::all_right()) return 1;
  for (const int cameras : {1, 2}) chasles::bench::measure(cameras);
}
