#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <chasles/base/constants.hpp>
#include <chasles/check/truth_imu_fit.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/recording/gravity.hpp>

namespace chasles {
namespace {

// gravity; bias; axes of the accelerometer; scale; heading; time of the positions; their point
using Vector15 = Eigen::Matrix<double, 15, 1>;
using Matrix15 = Eigen::Matrix<double, 15, 15>;
using Matrix3x15 = Eigen::Matrix<double, 3, 15>;
constexpr int kAxes = 6, kHeading = 10, kTime = 11;

constexpr double kReach = 0.5;       // of a window to both sides of its middle [s]
constexpr double kSampleGap = 0.05;  // [s]
constexpr double kSlope = 0.03;      // to both sides, for a velocity [s]
constexpr std::size_t kFewestWindows = 20;
constexpr int kFitSteps = 15;
constexpr std::size_t kScoreBlocks = 20;
constexpr double kMostTimeSigma = 0.02;  // [s]

struct TruthWindow {
  Time middle{};
  Eigen::Vector3d force;        // integral of h R f
  Eigen::Matrix3d rotation;     // of h R
  Eigen::Matrix3d force_cross;  // of h R f^
  double area = 0;              // of h
  Eigen::Matrix3d turn;         // second difference of R
};

struct WindowEquation {
  Eigen::Vector3d y;
  Matrix3x15 J;
};

// By the trapezoid over the samples. None where samples or attitudes are missing.
std::optional<TruthWindow> window_around(const Trajectory& truth, const std::vector<ImuSample>& imu,
                                         Time middle, double attitudes_late, Time gap) {
  TruthWindow window{.middle = middle,
                     .force = Eigen::Vector3d::Zero(),
                     .rotation = Eigen::Matrix3d::Zero(),
                     .force_cross = Eigen::Matrix3d::Zero(),
                     .turn = Eigen::Matrix3d::Zero()};
  const Time begin = middle - from_seconds(kReach), end = middle + from_seconds(kReach);
  auto sample = std::ranges::lower_bound(imu, begin, {}, &ImuSample::time);
  if (sample == imu.begin()) return std::nullopt;
  for (; sample != imu.end() && sample->time < end; ++sample) {
    if (sample + 1 == imu.end()) return std::nullopt;
    const double before = to_seconds(sample->time - std::prev(sample)->time);
    const double after = to_seconds(std::next(sample)->time - sample->time);
    if (std::max(before, after) > kSampleGap) return std::nullopt;
    const auto pose = pose_at(truth, sample->time + from_seconds(attitudes_late), gap);
    if (!pose) return std::nullopt;
    const double h = (before + after) / 2 * (kReach - std::abs(to_seconds(sample->time - middle)));
    window.force += h * pose->R * sample->specific_force_imu;
    window.rotation += h * pose->R;
    window.force_cross += h * pose->R * hat(sample->specific_force_imu);
    window.area += h;
  }
  if (sample == imu.end()) return std::nullopt;
  for (const auto& [time, factor] : {std::pair(begin, 1), {middle, -2}, {end, 1}}) {
    const auto pose = pose_at(truth, time + from_seconds(attitudes_late), gap);
    if (!pose) return std::nullopt;
    window.turn += factor * pose->R;
  }
  return window;
}

std::vector<TruthWindow> windows_of(const Trajectory& truth, const std::vector<ImuSample>& imu,
                                    double attitudes_late, Time gap) {
  std::vector<TruthWindow> windows;
  const Time step = from_seconds(kReach / 2);
  for (Time middle = imu.front().time + 2 * step; middle < imu.back().time; middle += step) {
    if (const auto window = window_around(truth, imu, middle, attitudes_late, gap)) {
      windows.push_back(*window);
    }
  }
  return windows;
}

struct Differences {
  Eigen::Vector3d position, velocity;  // second differences
};

std::optional<Differences> differences(const Trajectory& truth, Time middle, double late,
                                       Time gap) {
  std::array<Eigen::Vector3d, 3> p, v;
  for (int k = -1; k <= 1; ++k) {
    const auto position = [&](double shift) {
      return pose_at(truth, middle + from_seconds(k * kReach + late + shift), gap);
    };
    const auto before = position(-kSlope), here = position(0), after = position(kSlope);
    if (!before || !here || !after) return std::nullopt;
    const auto i = static_cast<std::size_t>(k + 1);
    p.at(i) = here->p;
    v.at(i) = (after->p - before->p) / (2 * kSlope);
  }
  return Differences{p[0] - 2 * p[1] + p[2], v[0] - 2 * v[1] + v[2]};
}

// With `late` of the current iteration; the equation's unknown is that time itself.
std::vector<WindowEquation> equations_of(const Trajectory& truth,
                                         const std::vector<TruthWindow>& windows,
                                         const Eigen::Vector3d& up, double late, Time gap) {
  std::vector<WindowEquation> equations;
  for (const TruthWindow& window : windows) {
    const auto difference = differences(truth, window.middle, late, gap);
    if (!difference) continue;
    WindowEquation& equation = equations.emplace_back();
    equation.y = difference->position - window.force - late * difference->velocity;
    equation.J << window.area * Eigen::Matrix3d::Identity(), -window.rotation, -window.force_cross,
        window.force, up.cross(window.force), -difference->velocity, window.turn;
  }
  return equations;
}

// Sigmas before the comparison: a bias and axes of the usual size, a known gravity, any point.
struct ImuPrior {
  Vector15 mean = Vector15::Zero();
  Matrix15 information = Matrix15::Zero();
};

ImuPrior prior_for(const Eigen::Vector3d& down) {
  constexpr double kGravity = 0.01, kBias = 0.3, kScaleSigma = 0.01, kTimeSigma = 0.1,
                   kPointSigma = 1;
  constexpr double kTurnSigma = 1.5 * kRadians;
  ImuPrior prior;
  prior.mean.head<3>() = kStandardGravity * down;
  prior.information.topLeftCorner<3, 3>() = down * down.transpose() / (kGravity * kGravity);
  Eigen::Matrix<double, 12, 1> sigma;
  sigma << Eigen::Vector3d::Constant(kBias), Eigen::Vector3d::Constant(kTurnSigma), kScaleSigma,
      kTurnSigma, kTimeSigma, Eigen::Vector3d::Constant(kPointSigma);
  prior.information.diagonal().tail<12>() = sigma.array().square().inverse();
  return prior;
}

struct ImuSolution {
  Vector15 x;
  Matrix15 covariance = Matrix15::Zero();
};

Eigen::Vector3d median_sigmas(const std::vector<WindowEquation>& equations, const Vector15& x) {
  constexpr double kOfMedian = 1.4826;  // of the sizes of normal numbers
  Eigen::Vector3d sigmas;
  std::vector<double> sizes(equations.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::transform(equations, sizes.begin(), [&](const WindowEquation& e) {
      return std::abs(e.y[axis] - e.J.row(axis).dot(x));
    });
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    sigmas[axis] = std::max(kOfMedian * *middle, 1e-9);
  }
  return sigmas;
}

// One reweighted step; the covariance by the scores of blocks.
void improve(const std::vector<WindowEquation>& equations, const ImuPrior& prior,
             ImuSolution& solution) {
  const Eigen::Vector3d sigmas = median_sigmas(equations, solution.x);
  Matrix15 H = prior.information, scores = prior.information;
  Vector15 g = prior.information * (prior.mean - solution.x), block = Vector15::Zero();
  for (std::size_t i = 0; i < equations.size(); ++i) {
    const Eigen::Vector3d left = equations[i].y - equations[i].J * solution.x;
    const Eigen::Vector3d scaled = left.cwiseQuotient(2 * sigmas);
    const Eigen::Vector3d weight =
        (sigmas.array().square() * (1 + scaled.array().square())).inverse();
    const Vector15 score = equations[i].J.transpose() * weight.asDiagonal() * left;
    H += equations[i].J.transpose() * weight.asDiagonal() * equations[i].J;
    g += score;
    block += score;
    const bool last =
        (i + 1) * kScoreBlocks / equations.size() != i * kScoreBlocks / equations.size();
    if (!last) continue;
    scores += block * block.transpose();
    block.setZero();
  }
  const Matrix15 inverse = H.inverse();
  solution.x += inverse * g;
  solution.covariance = inverse * scores * inverse;
}

// A turn of the axes about the vertical is one of the heading: the motion hardly parts the two.
Vector15 heading_of(const std::vector<TruthWindow>& windows, const Eigen::Vector3d& up) {
  Vector15 derivative = Vector15::Unit(kHeading);
  for (const TruthWindow& window : windows) {
    derivative.segment<3>(kAxes) +=
        window.rotation.transpose() * up / (window.area * static_cast<double>(windows.size()));
  }
  return derivative;
}

TruthImuFit fit_of(const ImuSolution& solution, const Vector15& heading, std::size_t windows) {
  const Eigen::Vector3d down = solution.x.head<3>().normalized();
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - down * down.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(
      Eigen::Matrix3d(across * solution.covariance.topLeftCorner<3, 3>() * across));
  return {.positions_late = solution.x[kTime],
          .positions_late_sigma = std::sqrt(solution.covariance(kTime, kTime)),
          .heading = heading.dot(solution.x),
          .heading_sigma = std::sqrt(heading.dot(solution.covariance * heading)),
          .tilt = std::atan2(down.head<2>().norm(), -down.z()),
          .tilt_sigma = std::sqrt(axes.eigenvalues()[2]) / kStandardGravity,
          .point = solution.x.tail<3>(),
          .point_sigma = solution.covariance.diagonal().tail<3>().cwiseSqrt(),
          .windows = static_cast<int>(windows)};
}

}  // namespace

std::optional<TruthImuFit> fit_truth_to_imu(const Trajectory& truth,
                                            const std::vector<ImuSample>& imu,
                                            double attitudes_late, Time gap) {
  Trajectory shifted = truth;  // to the clock of the IMU
  for (StampedPose& row : shifted) row.time -= from_seconds(attitudes_late);
  const auto gravity = fit_gravity(shifted, imu);
  if (!gravity || gravity->gravity_world.norm() < kStandardGravity / 2) return std::nullopt;
  const Eigen::Vector3d down = gravity->gravity_world.normalized();
  const ImuPrior prior = prior_for(down);
  const std::vector<TruthWindow> windows = windows_of(truth, imu, attitudes_late, gap);
  ImuSolution solution{.x = prior.mean};
  solution.x[kTime] = attitudes_late;
  std::size_t used = 0;
  for (int iteration = 0; iteration < kFitSteps; ++iteration) {
    const auto equations = equations_of(truth, windows, -down, solution.x[kTime], gap);
    used = equations.size();
    if (used < kFewestWindows) return std::nullopt;
    improve(equations, prior, solution);
    if (!solution.x.allFinite() || std::abs(solution.x[kTime]) > 1) return std::nullopt;
  }
  const TruthImuFit fit = fit_of(solution, heading_of(windows, -down), used);
  return fit.positions_late_sigma < kMostTimeSigma ? std::optional(fit) : std::nullopt;
}

}  // namespace chasles
