#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include <chasles/base/median.hpp>
#include <chasles/check/velocity_clock.hpp>
#include <chasles/imu/signal_noise.hpp>
#include <chasles/lie/se3.hpp>
#include <chasles/lie/small_matrices.hpp>

namespace chasles {
namespace {

constexpr double kApart = 0.4;     // [s] between two observations of a landmark
constexpr double kSpacing = 0.01;  // [s] by which frames are unevenly spaced
constexpr double kFarthest = 1e6;  // [m]: disparities of rounding
constexpr double kLargest = 0.3;   // [s]
constexpr double kCluster = 1;     // [s]: errors of tracks that share it are not independent
constexpr std::size_t kFewestClusters = 10;
constexpr std::size_t kMostIntervals = 1200;  // of a long recording, evenly spread
constexpr double kClockConverged = 1e-5;      // [s]
constexpr int kMostSteps = 30;
constexpr double kWidth = 2;             // of the loss, in sigmas
constexpr double kMedianOfTwo = 1.1774;  // median length of two normal numbers

// The unknowns: offset, bias of the rates, logarithm of the scale of the velocities, and the
// rotation between their axes and the IMU's.
constexpr int kUnknowns = 8;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;

BodyVelocity interpolated(const BodyVelocity& a, const BodyVelocity& b, Time time) {
  const double part = to_seconds(time - a.time) / to_seconds(b.time - a.time);
  return {.time = time,
          .linear_imu = (1 - part) * a.linear_imu + part * b.linear_imu,
          .angular_imu = (1 - part) * a.angular_imu + part * b.angular_imu};
}

// The samples as a continuous motion, piecewise linear.
class Motion {
 public:
  explicit Motion(const std::vector<BodyVelocity>& velocities) : velocities_(velocities) {}

  bool covers(Time begin, Time end) const {
    const Time margin = from_seconds(kLargest + 0.01);  // derivatives need a margin
    return begin - margin >= velocities_.front().time && end + margin <= velocities_.back().time;
  }

  // The motion from end to begin, in the frames' clock: the midpoint of each piece.
  SE3 between(Time begin, Time end, const Unknowns& x) const {
    const Time offset = from_seconds(x[0]);
    const Time last = end + offset;
    Time now = begin + offset;
    auto next = std::upper_bound(velocities_.begin(), velocities_.end(), now,
                                 [](Time t, const BodyVelocity& u) { return t < u.time; });
    const Eigen::Matrix3d turn = so3::exp(x.tail<3>());
    SE3 begin_T_now;
    while (now < last) {
      const Time to = std::min(last, next->time);
      const BodyVelocity said = interpolated(*(next - 1), *next, now + (to - now) / 2);
      Vector6d twist;
      twist << turn * said.angular_imu - x.segment<3>(1), std::exp(x[4]) * (turn * said.linear_imu);
      begin_T_now = begin_T_now * se3::exp(to_seconds(to - now) * twist);
      now = to;
      if (now == next->time) ++next;
    }
    return begin_T_now;
  }

 private:
  const std::vector<BodyVelocity>& velocities_;
};

struct Pair {
  Eigen::Vector3d p_imu;         // the landmark, from the first frame's observation
  Eigen::Vector3d by_disparity;  // derivative of p_imu by its disparity [m/px]
  Eigen::Vector2d centred;       // mean of both cameras' pixels in the later frame
};

// Two frames with their common landmarks.
struct Interval {
  Time begin{}, end{};
  std::vector<Pair> pairs;
};

Eigen::Vector2d centre(const Eigen::Vector4d& pixels) {
  return (pixels.head<2>() + pixels.tail<2>()) / 2;
}

std::vector<Interval> intervals_of(const Recording& r, const Motion& motion) {
  const SE3 imu_T_cam0 = r.rig.cam0_T_imu.inverse();
  std::vector<Interval> intervals;
  std::size_t later = 0;
  for (const FeatureFrame& frame : r.frames) {
    const Time due = frame.time + from_seconds(kApart - kSpacing);
    while (later < r.frames.size() && r.frames[later].time < due) ++later;
    if (later == r.frames.size()) break;
    const FeatureFrame& then = r.frames[later];
    if (to_seconds(then.time - frame.time) > 2 * kApart) continue;
    if (!motion.covers(frame.time, then.time)) continue;
    std::unordered_map<LandmarkId, Eigen::Vector2d> seen;
    for (const StereoObservation& o : then.observations) seen[o.landmark] = centre(o.pixels);
    Interval interval{.begin = frame.time, .end = then.time, .pairs = {}};
    for (const StereoObservation& o : frame.observations) {
      const auto found = seen.find(o.landmark);
      if (found == seen.end() || !o.pixels.allFinite() || !found->second.allFinite()) continue;
      const auto point = triangulate(r.rig, o.pixels);
      if (!point || !(point->p_cam0.norm() < kFarthest)) continue;
      const Eigen::Vector3d by_disparity = point->p_cam0 / (o.pixels[2] - o.pixels[0]);
      interval.pairs.push_back({.p_imu = imu_T_cam0 * point->p_cam0,
                                .by_disparity = imu_T_cam0.R * by_disparity,
                                .centred = found->second});
    }
    if (!interval.pairs.empty()) intervals.push_back(std::move(interval));
  }
  const std::size_t stride = intervals.size() / kMostIntervals + 1;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < intervals.size(); i += stride) {
    if (kept != i) intervals[kept] = std::move(intervals[i]);
    ++kept;
  }
  intervals.resize(kept);
  return intervals;
}

// A pixel's error and its derivative by the unknowns.
struct Row {
  std::size_t cluster;
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, kUnknowns> J;
};

// The weight of a pixel that moves by g with the disparity of the first observation, if that
// disparity has the uncertainty of the pixel: (I + g g^T)^(-1/2).
Eigen::Matrix2d whitening(const Eigen::Vector2d& g) {
  const double square = g.squaredNorm();
  if (square < 1e-12) return Eigen::Matrix2d::Identity();
  return Eigen::Matrix2d::Identity() - (1 - 1 / std::sqrt(1 + square)) / square * g * g.transpose();
}

class Fit {
 public:
  Fit(const Recording& r, const Motion& motion, const std::vector<Interval>& intervals)
      : rig_(r.rig), motion_(motion), intervals_(intervals) {}

  std::vector<Row> rows(const Unknowns& x) const {
    std::vector<Row> all;
    const Time first = intervals_.front().begin;
    for (const Interval& interval : intervals_) {
      const SE3 then_T_now = motion_.between(interval.begin, interval.end, x).inverse();
      const auto moves = derivative(interval, x);
      const auto cluster = static_cast<std::size_t>(to_seconds(interval.begin - first) / kCluster);
      for (const Pair& pair : interval.pairs) {
        const Eigen::Vector3d p_imu = then_T_now * pair.p_imu;
        const auto seen = project(rig_, rig_.cam0_T_imu * p_imu);
        if (!seen) continue;
        Eigen::Matrix<double, 3, 6> by_motion;  // of then_T_now = Exp(-delta) then_T_now
        by_motion << hat(p_imu), -Eigen::Matrix3d::Identity();
        const Eigen::Matrix<double, 2, 3> by_point =
            (seen->d_point.topRows<2>() + seen->d_point.bottomRows<2>()) / 2 * rig_.cam0_T_imu.R;
        const Eigen::Matrix2d W = whitening(by_point * (then_T_now.R * pair.by_disparity));
        all.push_back(
            {cluster, W * (pair.centred - centre(seen->pixels)), W * by_point * by_motion * moves});
      }
    }
    return all;
  }

 private:
  // Of delta in now_T_then Exp(delta).
  Eigen::Matrix<double, 6, kUnknowns> derivative(const Interval& interval,
                                                 const Unknowns& x) const {
    constexpr double kStep = 1e-4;
    Eigen::Matrix<double, 6, kUnknowns> result;
    for (int i = 0; i < kUnknowns; ++i) {
      const Unknowns step = kStep * Unknowns::Unit(i);
      const SE3 less = motion_.between(interval.begin, interval.end, x - step),
                more = motion_.between(interval.begin, interval.end, x + step);
      result.col(i) = se3::log(less.inverse() * more) / (2 * kStep);
    }
    return result;
  }

  const StereoRig& rig_;
  const Motion& motion_;
  const std::vector<Interval>& intervals_;
};

double scatter_of(const std::vector<Row>& rows) {
  std::vector<double> lengths;
  for (const Row& row : rows) lengths.push_back(row.residual.norm());
  return median(std::move(lengths)) / kMedianOfTwo;
}

// Cauchy weight: moving cars, and disparities that are wrong by tens of pixels, must not affect the
// fit.
double weight_of(const Row& row, double scatter) {
  return 1 / (1 + row.residual.squaredNorm() / (kWidth * kWidth * scatter * scatter));
}

Normal normal_of(const std::vector<Row>& rows, double scatter, Unknowns& right) {
  Normal A = 1e-9 * Normal::Identity();
  right.setZero();
  for (const Row& row : rows) {
    const double weight = weight_of(row, scatter);
    A.noalias() += weight * row.J.transpose() * row.J;
    right.noalias() += weight * row.J.transpose() * row.residual;
  }
  return A;
}

// A^-1 (sum over clusters of g g^T) A^-1, with g the gradient of each.
double sigma_of(const std::vector<Row>& rows, double scatter, std::size_t& clusters) {
  Unknowns right;
  const Normal inverse = inverse_symmetric(normal_of(rows, scatter, right));
  std::map<std::size_t, Unknowns> gradients;
  for (const Row& row : rows) {
    auto [gradient, fresh] = gradients.try_emplace(row.cluster, Unknowns::Zero());
    gradient->second += weight_of(row, scatter) * row.J.transpose() * row.residual;
  }
  clusters = gradients.size();
  Normal middle = Normal::Zero();
  for (const auto& [cluster, gradient] : gradients) middle += gradient * gradient.transpose();
  return std::sqrt((inverse * middle * inverse)(0, 0));
}

// The effect of the samples' white noise on a pixel within an interval.
double noise_in_pixels(const Recording& r, const std::vector<Interval>& intervals) {
  Vector6d sigma;
  if (r.velocity_sigma) {
    sigma << r.velocity_sigma->angular, r.velocity_sigma->linear;
  } else {
    const auto axes = measure_axes(r.velocities);
    for (Eigen::Index i = 0; i < 6; ++i) sigma[i] = axes[static_cast<std::size_t>(i)].white;
  }
  std::vector<double> depths;
  for (const Interval& interval : intervals) {
    for (const Pair& pair : interval.pairs) {
      depths.push_back((r.rig.cam0_T_imu * pair.p_imu).z());
    }
  }
  const double depth = median(std::move(depths));
  const double period = to_seconds(r.velocities.back().time - r.velocities.front().time) /
                        static_cast<double>(r.velocities.size() - 1);
  return r.rig.fx * std::sqrt(period * kApart) *
         std::hypot(sigma.head<3>().maxCoeff(), sigma.tail<3>().maxCoeff() / depth);
}

}  // namespace

bool VelocityClock::is_determined() const { return sample_noise < scatter; }

bool VelocityClock::stands_out() const {
  return is_determined() && std::abs(offset) > std::max(kLeastOffset, 3 * sigma);
}

std::optional<VelocityClock> velocity_clock(const Recording& r) {
  if (r.velocities.size() < 2 || r.frames.size() < 2 || !(r.rig.fx > 0)) return std::nullopt;
  const Motion motion(r.velocities);
  const std::vector<Interval> intervals = intervals_of(r, motion);
  if (intervals.empty()) return std::nullopt;
  const Fit fit(r, motion, intervals);
  Unknowns x = Unknowns::Zero();
  VelocityClock clock{.sample_noise = noise_in_pixels(r, intervals)};
  bool converged = false;
  for (int k = 0; k < kMostSteps && !converged; ++k) {
    const std::vector<Row> rows = fit.rows(x);
    if (rows.size() < 2 * kUnknowns) return std::nullopt;
    clock.scatter = std::max(scatter_of(rows), 1e-6);
    if (!clock.is_determined()) return clock;
    Unknowns right;
    const Normal A = normal_of(rows, clock.scatter, right);
    const Unknowns step = solve_symmetric<kUnknowns, 1>(A, right);
    if (!step.allFinite()) return std::nullopt;
    x += step;
    if (std::abs(x[0]) > kLargest) return std::nullopt;
    converged = std::abs(step[0]) < kClockConverged;
  }
  std::size_t clusters = 0;
  clock.offset = x[0];
  clock.sigma = sigma_of(fit.rows(x), clock.scatter, clusters);
  if (!converged || clusters < kFewestClusters || !std::isfinite(clock.sigma)) return std::nullopt;
  return clock;
}

void shift_velocities(Recording& r, double offset) {
  if (offset == 0 || r.velocities.empty()) return;
  const Time started = r.velocities.front().time;
  for (BodyVelocity& u : r.velocities) u.time -= from_seconds(offset);
  if (r.frames.empty() || started < r.frames.front().time) return;
  const Time first = r.frames.front().time;
  const auto after =
      std::ranges::find_if(r.velocities, [&](const BodyVelocity& u) { return u.time >= first; });
  if (after == r.velocities.begin() || after == r.velocities.end()) return;
  if (after->time > first) *(after - 1) = interpolated(*(after - 1), *after, first);
  r.velocities.erase(r.velocities.begin(), after->time > first ? after - 1 : after);
}

}  // namespace chasles
