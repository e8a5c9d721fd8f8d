#include <algorithm>
#include <cmath>
#include <iterator>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include <chasles/calibrate/rotation_alignment.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kLongestTurn = 0.25;  // between two attitudes [s]
constexpr std::size_t kLeastTurns = 10;

struct Turn {
  double from, to;    // [s] since the first sample, camera's clock
  Vector3d rate_cam;  // mean [rad/s]
};

// The integral of the rates, at any time.
class RateIntegral {
 public:
  explicit RateIntegral(const std::vector<ImuSample>& imu) {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t i = 0; i < imu.size(); ++i) {
      const double t = to_seconds(imu[i].time - imu[0].time);
      if (i > 0)
        sum += (t - times_.back()) / 2 * (imu[i].angular_rate_imu + imu[i - 1].angular_rate_imu);
      times_.push_back(t);
      sums_.push_back(sum);
    }
  }

  // Whether there are samples about a time.
  bool covers(double t) const {
    if (!(t >= times_.front() && t <= times_.back())) return false;
    const auto after = std::ranges::lower_bound(times_, t);
    return after == times_.begin() || *after - *std::prev(after) <= kLongestTurn;
  }
  Vector3d at(double t) const {
    const auto after =
        std::clamp<std::ptrdiff_t>(std::ranges::upper_bound(times_, t) - times_.begin(), 1,
                                   static_cast<std::ptrdiff_t>(times_.size()) - 1);
    const auto i = static_cast<std::size_t>(after);
    const double part = (t - times_[i - 1]) / (times_[i] - times_[i - 1]);
    return sums_[i - 1] + part * (sums_[i] - sums_[i - 1]);
  }

 private:
  std::vector<double> times_;
  std::vector<Vector3d> sums_;
};

std::optional<RotationAlignment> aligned_at(const std::vector<Turn>& turns,
                                            const RateIntegral& integral, double offset) {
  std::vector<Vector3d> cam, imu;
  for (const Turn& turn : turns) {
    const double from = turn.from + offset, to = turn.to + offset;
    if (!integral.covers(from) || !integral.covers(to)) continue;
    cam.push_back(turn.rate_cam);
    imu.push_back((integral.at(to) - integral.at(from)) / (to - from));
  }
  if (cam.size() < kLeastTurns || 2 * cam.size() < turns.size()) return std::nullopt;
  Vector3d of_cam = Vector3d::Zero(), of_imu = Vector3d::Zero();
  for (std::size_t i = 0; i < cam.size(); ++i) of_cam += cam[i], of_imu += imu[i];
  of_cam /= static_cast<double>(cam.size());
  of_imu /= static_cast<double>(cam.size());
  Matrix3d H = Matrix3d::Zero();
  double squares = 0;
  for (std::size_t i = 0; i < cam.size(); ++i) {
    H += (cam[i] - of_cam) * (imu[i] - of_imu).transpose();
    squares += (cam[i] - of_cam).squaredNorm() + (imu[i] - of_imu).squaredNorm();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d sign = Matrix3d::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  RotationAlignment result{.cam_R_imu = svd.matrixU() * sign * svd.matrixV().transpose(),
                           .time_offset = offset,
                           .gyroscope_bias = {},
                           .unexplained = 0};
  const double explained = 2 * (svd.singularValues().asDiagonal() * sign).diagonal().sum();
  result.unexplained = squares > 0 ? std::max(0.0, 1 - explained / squares) : 1;
  result.gyroscope_bias = of_imu - result.cam_R_imu.transpose() * of_cam;
  return result;
}

}  // namespace

std::optional<RotationAlignment> align_rotations(const std::vector<SeenAttitude>& attitudes,
                                                 const std::vector<ImuSample>& imu, double most) {
  if (imu.size() < 2) return std::nullopt;
  std::vector<Turn> turns;
  for (std::size_t i = 0; i + 1 < attitudes.size(); ++i) {
    const double from = to_seconds(attitudes[i].time - imu[0].time);
    const double to = to_seconds(attitudes[i + 1].time - imu[0].time);
    if (to <= from || to - from > kLongestTurn) continue;
    const Matrix3d turned = attitudes[i + 1].cam_R_target * attitudes[i].cam_R_target.transpose();
    turns.push_back({from, to, -so3::log(turned) / (to - from)});
  }
  if (turns.size() < kLeastTurns) return std::nullopt;
  const RateIntegral integral(imu);
  std::optional<RotationAlignment> best;
  const auto search = [&](double from, double to, double step) {
    for (double offset = from; offset <= to; offset += step) {
      const auto one = aligned_at(turns, integral, offset);
      if (one && (!best || one->unexplained < best->unexplained)) best = one;
    }
  };
  search(-most, most, 0.01);
  if (!best) return std::nullopt;
  for (const double step : {0.002, 0.0004}) {
    const double middle = best->time_offset;
    search(middle - 5 * step, middle + 5 * step, step);
  }
  return best;
}

}  // namespace chasles
