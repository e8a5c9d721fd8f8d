#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>
#include <Eigen/SVD>

#include <chasles/check/check_rotation.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr std::size_t kFewestIntervals = 20;
constexpr double kLargestOffset = 0.5;           // [s]
constexpr double kCoarse = 0.01, kFine = 0.001;  // steps of the offset [s]
constexpr double kTurning = 0.02;                // rates that vary less give no information [rad/s]
constexpr double kRotationConverged = 1e-3;      // [rad]
constexpr double kOtherUnit = 10;  // a larger gain is another unit, not an error of scale
constexpr double kMirror = 0.2;    // third over first singular value

using Vector3 = Eigen::Vector3d;
using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;

// The integral of the gyroscope's rate from its first sample on: piecewise linear, with the mean of
// the two samples in each interval.
class Turned {
 public:
  explicit Turned(const std::vector<StampedRate>& rates) : rates_(&rates), sums_(rates.size()) {
    sums_[0].setZero();
    for (std::size_t i = 1; i < rates.size(); ++i) {
      sums_[i] = sums_[i - 1] + (rates[i].rate_imu + rates[i - 1].rate_imu) / 2 *
                                    to_seconds(rates[i].time - rates[i - 1].time);
    }
  }
  bool covers(Time time) const {
    return time >= rates_->front().time && time <= rates_->back().time;
  }
  // The mean rate of an interval, shifted.
  Vector3 mean(const RotationRate& interval, Time offset) const {
    return (at(interval.end + offset) - at(interval.begin + offset)) /
           to_seconds(interval.end - interval.begin);
  }
  Vector3 at(Time time) const {
    const auto later =
        std::upper_bound(rates_->begin() + 1, rates_->end() - 1, time,
                         [](Time t, const StampedRate& rate) { return t < rate.time; });
    const auto i = static_cast<std::size_t>(later - rates_->begin());
    const double span = to_seconds((*rates_)[i].time - (*rates_)[i - 1].time);
    const double part = to_seconds(time - (*rates_)[i - 1].time) / span;
    return sums_[i - 1] + part * (sums_[i] - sums_[i - 1]);
  }

 private:
  const std::vector<StampedRate>* rates_;
  std::vector<Vector3> sums_;
};

// camera's rate = gain R (gyroscope's rate) + bias.
struct Alignment {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  double gain = 1;
  Vector3 bias = Vector3::Zero();
  bool mirrored = false;
  double cost = 0;  // mean of sqrt(1 + Mahalanobis distance^2)

  Vector3 residual(const RotationRate& interval, const Vector3& imu) const {
    return interval.rate_cam - gain * (R * imu) - bias;
  }
};

// Kabsch and Umeyama, with each interval weighted by the information of its weakest axis.
Alignment first_alignment(const std::vector<RotationRate>& intervals,
                          const std::vector<Vector3>& imu, const std::vector<double>& weights) {
  Vector3 cam_mean = Vector3::Zero(), imu_mean = Vector3::Zero();
  double sum = 0;
  for (std::size_t i = 0; i < imu.size(); ++i) {
    cam_mean += weights[i] * intervals[i].rate_cam;
    imu_mean += weights[i] * imu[i];
    sum += weights[i];
  }
  cam_mean /= sum;
  imu_mean /= sum;
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  double power = 1e-12;
  for (std::size_t i = 0; i < imu.size(); ++i) {
    const Vector3 turned = imu[i] - imu_mean;
    H += weights[i] / sum * (intervals[i].rate_cam - cam_mean) * turned.transpose();
    power += weights[i] / sum * turned.squaredNorm();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vector3 values = svd.singularValues();
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  Alignment first;
  first.R = svd.matrixU() * Vector3(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
  first.gain = (values[0] + values[1] + sign * values[2]) / power;
  first.bias = cam_mean - first.gain * (first.R * imu_mean);
  first.mirrored = sign < 0 && values[2] > kMirror * values[0];
  return first;
}

// Derivatives of the prediction by rotation (Exp(delta) R), bias and gain.
Eigen::Matrix<double, 3, 7> derivative(const Alignment& a, const Vector3& imu) {
  Eigen::Matrix<double, 3, 7> J;
  J << -hat(a.gain * (a.R * imu)), Eigen::Matrix3d::Identity(), a.R * imu;
  return J;
}

// Gauss-Newton with each interval's full information matrix and a pseudo-Huber weight.
Alignment align(const std::vector<RotationRate>& intervals, const std::vector<Vector3>& imu,
                const std::vector<double>& weights, int iterations) {
  Alignment a = first_alignment(intervals, imu, weights);
  for (int iteration = 0; iteration < iterations; ++iteration) {
    Matrix7d A = Matrix7d::Zero();
    Vector7d b = Vector7d::Zero();
    for (std::size_t i = 0; i < imu.size(); ++i) {
      const Vector3 r = a.residual(intervals[i], imu[i]);
      const Eigen::Matrix3d& L = intervals[i].information;
      const double weight = 1 / std::sqrt(1 + r.dot(L * r));
      const auto J = derivative(a, imu[i]);
      A.noalias() += weight * J.transpose() * L * J;
      b.noalias() += weight * J.transpose() * (L * r);
    }
    A.diagonal().array() *= 1 + 1e-6;
    const Vector7d step = solve_symmetric(A, b);
    if (!step.allFinite()) break;
    a.R = so3::exp(step.head<3>()) * a.R;
    a.bias += step.segment<3>(3);
    a.gain += step[6];
  }
  for (std::size_t i = 0; i < imu.size(); ++i) {
    const Vector3 r = a.residual(intervals[i], imu[i]);
    a.cost += std::sqrt(1 + r.dot(intervals[i].information * r)) / static_cast<double>(imu.size());
  }
  return a;
}

// The fit at any offset.
class Search {
 public:
  Search(const std::vector<RotationRate>& rates, const std::vector<StampedRate>& gyroscope)
      : turned_(gyroscope) {
    const Time margin = from_seconds(kLargestOffset + 2 * kCoarse);
    for (const RotationRate& rate : rates) {
      if (!turned_.covers(rate.begin - margin) || !turned_.covers(rate.end + margin)) continue;
      intervals_.push_back(rate);
      weights_.push_back(std::max(symmetric_eigen(rate.information).values[0], 1e-6));
    }
  }
  const std::vector<RotationRate>& intervals() const { return intervals_; }
  std::vector<Vector3> gyroscope(double offset) const {
    std::vector<Vector3> rates;
    for (const RotationRate& rate : intervals_) {
      rates.push_back(turned_.mean(rate, from_seconds(offset)));
    }
    return rates;
  }
  Alignment at(double offset, int iterations = 8) const {
    return align(intervals_, gyroscope(offset), weights_, iterations);
  }
  // The best offset from `first` on.
  double best(double first, double step, int count, int iterations) const {
    double least = std::numeric_limits<double>::infinity(), found = first;
    for (int k = 0; k < count; ++k) {
      const double cost = at(first + step * k, iterations).cost;
      if (cost >= least) continue;
      least = cost;
      found = first + step * k;
    }
    return found;
  }
  // The minimum of the parabola through three costs one step apart.
  double refined(double offset) const {
    const double before = at(offset - kFine).cost, here = at(offset).cost,
                 after = at(offset + kFine).cost;
    const double bend = before - 2 * here + after;
    return bend > 0 ? offset + std::clamp((before - after) / (2 * bend), -1.0, 1.0) * kFine
                    : offset;
  }
  // The number of intervals that cover the same time: their noise is not independent.
  double overlap() const {
    double sum = 0;
    for (const RotationRate& rate : intervals_) sum += to_seconds(rate.end - rate.begin);
    return std::max(1.0, sum / to_seconds(intervals_.back().end - intervals_.front().begin));
  }

 private:
  Turned turned_;
  std::vector<RotationRate> intervals_;
  std::vector<double> weights_;
};

// Joint standard deviations of rotation, gain and offset, scaled by the median of the Mahalanobis
// distances (2.366 for three components that match their information).
void add_sigmas(const Search& search, const Alignment& best, GyroscopeFit& fit) {
  const auto imu = search.gyroscope(fit.offset), later = search.gyroscope(fit.offset + kFine),
             earlier = search.gyroscope(fit.offset - kFine);
  Matrix8d A = Matrix8d::Identity() * 1e-9;
  std::vector<double> squares;
  for (std::size_t i = 0; i < imu.size(); ++i) {
    const RotationRate& interval = search.intervals()[i];
    const Vector3 r = best.residual(interval, imu[i]);
    squares.push_back(r.dot(interval.information * r));
    Eigen::Matrix<double, 3, 8> J;
    J << derivative(best, imu[i]), best.gain * (best.R * (later[i] - earlier[i])) / (2 * kFine);
    A.noalias() += J.transpose() * interval.information * J;
  }
  const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
  std::nth_element(squares.begin(), middle, squares.end());
  const Matrix8d P = inverse_symmetric(A) * (*middle / 2.366 * search.overlap());
  const double widest = symmetric_eigen(P.topLeftCorner<3, 3>()).values[2];
  fit.rotation_sigma = std::sqrt(std::max(widest, 0.0));
  fit.gain_sigma = std::sqrt(std::max(P(6, 6), 0.0));
  fit.offset_sigma = std::sqrt(std::max(P(7, 7), 0.0));
}

// Root mean square about the mean.
double variation(const std::vector<Vector3>& rates) {
  Vector3 mean = Vector3::Zero();
  double square = 0;
  const auto n = static_cast<double>(rates.size());
  for (const Vector3& rate : rates) {
    mean += rate / n;
    square += rate.squaredNorm() / n;
  }
  return std::sqrt(std::max(0.0, square - mean.squaredNorm()));
}

// second_R_first of the camera, predicted by the gyroscope and a fit.
std::optional<Eigen::Matrix3d> guessed(const Turned& turned, const GyroscopeFit& fit, Time begin,
                                       Time end) {
  const Time offset = from_seconds(fit.offset);
  if (!turned.covers(begin + offset) || !turned.covers(end + offset)) return std::nullopt;
  const bool same_unit = fit.gain > 1 / kOtherUnit && fit.gain < kOtherUnit;
  const Vector3 turn_imu = turned.at(end + offset) - turned.at(begin + offset);
  const Vector3 turn_cam = (same_unit ? 1 : fit.gain) * (fit.cam_R_imu * turn_imu) +
                           to_seconds(end - begin) * fit.bias_cam;
  return so3::exp(-turn_cam);
}

}  // namespace

std::optional<GyroscopeFit> fit_gyroscope(const std::vector<RotationRate>& rates,
                                          const std::vector<StampedRate>& gyroscope) {
  if (gyroscope.size() < 3) return std::nullopt;
  const Search search(rates, gyroscope);
  if (search.intervals().size() < kFewestIntervals) return std::nullopt;
  if (variation(search.gyroscope(0)) < kTurning) return std::nullopt;
  const int coarse = static_cast<int>(std::lround(2 * kLargestOffset / kCoarse)) + 1;
  const double near = search.best(-kLargestOffset, kCoarse, coarse, 3);
  GyroscopeFit fit;
  fit.offset = search.refined(search.best(near - kCoarse, kFine, 21, 5));
  const Alignment best = search.at(fit.offset);
  fit.cam_R_imu = best.R;
  fit.gain = best.gain;
  fit.mirrored = best.mirrored;
  fit.intervals = search.intervals().size();
  fit.bias_cam = best.bias;
  add_sigmas(search, best, fit);
  return fit;
}

std::optional<GyroscopeFit> fit_gyroscope(const std::vector<SeenTwice>& seen,
                                          const std::vector<StampedRate>& gyroscope, int passes) {
  const auto first = fit_gyroscope(rotation_rates(seen), gyroscope);
  if (!first || first->mirrored || passes == 1) return first;
  return fit_gyroscope_from(*first, seen, gyroscope, passes - 1);
}

std::optional<GyroscopeFit> fit_gyroscope_from(const GyroscopeFit& start,
                                               const std::vector<SeenTwice>& seen,
                                               const std::vector<StampedRate>& gyroscope,
                                               int passes) {
  const Turned turned(gyroscope);
  std::optional<GyroscopeFit> fit = start;
  for (int pass = 0; pass < passes && !fit->mirrored; ++pass) {
    const GyroscopeFit before = *fit;
    const auto guess = [&](Time begin, Time end) { return guessed(turned, before, begin, end); };
    fit = fit_gyroscope(rotation_rates(seen, guess), gyroscope);
    if (!fit) return std::nullopt;
    if (so3::log(before.cam_R_imu.transpose() * fit->cam_R_imu).norm() < kRotationConverged) break;
  }
  return fit;
}

}  // namespace chasles
