#include <algorithm>
#include <cmath>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/numeric/spline.hpp>

namespace chasles {
namespace {

using Eigen::Vector4d;

// Position of a time on the spline: its segment (which uses the controls `first` to `first` + 3)
// and the offset in it, in knot intervals.
struct Place {
  std::size_t first;
  double u;
};

Place place_of(const Spline& spline, double time) {
  const double x = time / spline.knot_interval;
  const auto last = static_cast<double>(spline.controls.size() - 4);
  const double segment = std::clamp(std::floor(x), 0.0, last);
  return {static_cast<std::size_t>(segment), x - segment};
}

// The uniform cubic B-spline's weights of the four controls, and their derivatives by u.
Vector4d weights(double u) {
  const double w = 1 - u;
  return Vector4d(w * w * w, 4 + u * u * (3 * u - 6), 1 + 3 * u * (1 + u * w), u * u * u) / 6;
}
Vector4d weights_1(double u) {
  return Vector4d(-(1 - u) * (1 - u), u * (3 * u - 4), 1 + u * (2 - 3 * u), u * u) / 2;
}
Vector4d weights_2(double u) { return {1 - u, 3 * u - 2, 1 - 3 * u, u}; }

// The cumulative form: the weights of the increments after the first control.
Eigen::Vector3d cumulated(const Vector4d& b) { return {b[1] + b[2] + b[3], b[2] + b[3], b[3]}; }

struct Turning {
  Eigen::Matrix3d R;
  Eigen::Vector3d omega;
};

Eigen::Vector3d step_of(const Spline& spline, std::size_t i) {
  return so3::log(spline.controls[i].R.transpose() * spline.controls[i + 1].R);
}

Turning turning_at(const Spline& spline, const Place& at) {
  const Eigen::Vector3d amount = cumulated(weights(at.u));
  const Eigen::Vector3d rate = cumulated(weights_1(at.u)) / spline.knot_interval;
  Turning result{spline.controls[at.first].R, Eigen::Vector3d::Zero()};
  for (int j = 0; j < 3; ++j) {
    const std::size_t i = at.first + static_cast<std::size_t>(j);
    const Eigen::Vector3d step = step_of(spline, i);
    const Eigen::Matrix3d turn = so3::exp(amount[j] * step);
    result.R = result.R * turn;
    result.omega = turn.transpose() * result.omega + rate[j] * step;
  }
  return result;
}

Eigen::Vector3d mix(const Spline& spline, std::size_t first, const Vector4d& weight) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int j = 0; j < 4; ++j) {
    sum += weight[j] * spline.controls[first + static_cast<std::size_t>(j)].p;
  }
  return sum;
}

struct Sample {
  double time;
  SE3 pose;
};

SE3 between(const SE3& a, const SE3& b, double s) {
  return {a.R * so3::exp(s * so3::log(a.R.transpose() * b.R)), a.p + s * (b.p - a.p)};
}

[[noreturn]] void reject(const std::string& found, const std::string& expected) {
  throw UsageError(fmt::format("trajectory to simulate: {}; expected {}", found, expected));
}

// The poses over the seconds after the first one. Gaps are filled so that neighbours are at most a
// knot interval apart and every segment has poses.
std::vector<Sample> without_gaps(const Trajectory& poses, double knot_interval) {
  if (poses.size() < 2) reject(fmt::format("{} poses", poses.size()), "at least 2");
  std::vector<Sample> samples{{0, poses.front().pose}};
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Sample last = samples.back();
    const Sample next{to_seconds(poses[i].time - poses.front().time), poses[i].pose};
    if (next.time <= last.time) {
      reject(fmt::format("pose {} is not later than the one before", i), "rising times");
    }
    const double pieces = std::ceil((next.time - last.time) / knot_interval);
    if (pieces > 1e6) {
      reject(fmt::format("a gap of {:.0f} s before pose {}", next.time - last.time, i),
             fmt::format("at most 1e6 times the knot interval of {} s", knot_interval));
    }
    for (double k = 1; k < pieces; ++k) {
      samples.push_back({last.time + (next.time - last.time) * k / pieces,
                         between(last.pose, next.pose, k / pieces)});
    }
    samples.push_back(next);
  }
  return samples;
}

// The poses at the knots (the middle of each control's support): the initial values of the fit.
std::vector<SE3> first_guess(const std::vector<Sample>& samples, std::size_t count,
                             double knot_interval) {
  std::vector<SE3> controls;
  std::size_t next = 1;
  for (std::size_t i = 0; i < count; ++i) {
    const double time = (static_cast<double>(i) - 1) * knot_interval;
    while (next + 1 < samples.size() && samples[next].time < time) ++next;
    const Sample& a = samples[next - 1];
    const Sample& b = samples[next];
    const double s = std::clamp((time - a.time) / (b.time - a.time), 0.0, 1.0);
    controls.push_back(between(a.pose, b.pose, s));
  }
  return controls;
}

using Solver = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>;

// A penalty on the fourth differences of the controls, which are zero for a cubic. It determines
// the outermost controls, which the samples do not. Its weight is too small to matter elsewhere.
constexpr double kSmoothness = 1e-8;
const Eigen::Matrix<double, 5, 1> kFourthDifference(1, -4, 6, -4, 1);

void add_square(std::vector<Eigen::Triplet<double>>& entries, std::size_t first,
                const Eigen::VectorXd& row, double weight) {
  const auto from = static_cast<int>(first);
  for (int i = 0; i < row.size(); ++i) {
    for (int j = 0; j < row.size(); ++j) {
      entries.emplace_back(from + i, from + j, weight * row[i] * row[j]);
    }
  }
}

// The normal equations of the controls of a curve through the samples.
Eigen::SparseMatrix<double> normal_equations(const Spline& spline,
                                             const std::vector<Sample>& samples) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const Sample& sample : samples) {
    const Place at = place_of(spline, sample.time);
    add_square(entries, at.first, weights(at.u), 1);
  }
  for (std::size_t i = 0; i + 4 < spline.controls.size(); ++i) {
    add_square(entries, i, kFourthDifference, kSmoothness);
  }
  const auto n = static_cast<Eigen::Index>(spline.controls.size());
  for (int i = 0; i < n; ++i) entries.emplace_back(i, i, 1e-14);
  Eigen::SparseMatrix<double> normal(n, n);
  normal.setFromTriplets(entries.begin(), entries.end());
  return normal;
}

// The change of every control, from the residuals of the samples and from the fourth differences.
// The latter are the third differences of the `steps` from each control to the next.
template <typename Residual, typename Step>
Eigen::MatrixX3d correction(const Spline& spline, const std::vector<Sample>& samples,
                            const Solver& solver, const Residual& residual, const Step& step) {
  Eigen::MatrixX3d sum =
      Eigen::MatrixX3d::Zero(static_cast<Eigen::Index>(spline.controls.size()), 3);
  for (const Sample& sample : samples) {
    const Place at = place_of(spline, sample.time);
    sum.middleRows<4>(static_cast<Eigen::Index>(at.first)) +=
        weights(at.u) * residual(sample, at).transpose();
  }
  for (std::size_t i = 0; i + 4 < spline.controls.size(); ++i) {
    const Eigen::Vector3d rough = step(i + 3) - 3 * step(i + 2) + 3 * step(i + 1) - step(i);
    sum.middleRows<5>(static_cast<Eigen::Index>(i)) -=
        kSmoothness * kFourthDifference * rough.transpose();
  }
  return solver.solve(sum);
}

void fit_positions(Spline& spline, const std::vector<Sample>& samples, const Solver& solver) {
  const Eigen::MatrixX3d change = correction(
      spline, samples, solver,
      [&](const Sample& sample, const Place& at) {
        return Eigen::Vector3d(sample.pose.p - mix(spline, at.first, weights(at.u)));
      },
      [&](std::size_t i) {
        return Eigen::Vector3d(spline.controls[i + 1].p - spline.controls[i].p);
      });
  for (std::size_t i = 0; i < spline.controls.size(); ++i) {
    spline.controls[i].p += change.row(static_cast<Eigen::Index>(i)).transpose();
  }
}

// Newton's method with the derivative of a spline in a vector space. It is exact for rotations
// about one axis. Otherwise each step leaves a fraction of the error, of the size of the rotation
// in a knot interval.
void fit_attitudes(Spline& spline, const std::vector<Sample>& samples, const Solver& solver) {
  constexpr int kMostSteps = 30;
  for (int iteration = 0; iteration < kMostSteps; ++iteration) {
    const Eigen::MatrixX3d change = correction(
        spline, samples, solver,
        [&](const Sample& sample, const Place& at) {
          return so3::log(turning_at(spline, at).R.transpose() * sample.pose.R);
        },
        [&](std::size_t i) { return step_of(spline, i); });
    for (std::size_t i = 0; i < spline.controls.size(); ++i) {
      Eigen::Matrix3d& R = spline.controls[i].R;
      R = so3::normalized(R * so3::exp(change.row(static_cast<Eigen::Index>(i)).transpose()));
    }
    if (change.cwiseAbs().maxCoeff() < 1e-12) return;
  }
}

}  // namespace

Motion motion_at(const Spline& spline, double time) {
  const Place at = place_of(spline, time);
  const double h = spline.knot_interval;
  const Turning turning = turning_at(spline, at);
  return {.world_T_imu = {turning.R, mix(spline, at.first, weights(at.u))},
          .v_world = mix(spline, at.first, weights_1(at.u)) / h,
          .a_world = mix(spline, at.first, weights_2(at.u)) / (h * h),
          .omega_imu = turning.omega};
}

Spline fit_spline(const Trajectory& poses, double knot_interval) {
  const std::vector<Sample> samples = without_gaps(poses, knot_interval);
  Spline spline{.start = poses.front().time,
                .knot_interval = knot_interval,
                .controls = {},
                .duration = samples.back().time};
  if (spline.duration < knot_interval) {
    reject(fmt::format("it lasts {} s", spline.duration),
           fmt::format("at least one knot interval, {} s", knot_interval));
  }
  const auto segments = static_cast<std::size_t>(std::ceil(spline.duration / knot_interval - 1e-9));
  spline.controls = first_guess(samples, segments + 3, knot_interval);
  const Solver solver(normal_equations(spline, samples));
  fit_positions(spline, samples, solver);
  fit_attitudes(spline, samples, solver);
  return spline;
}

}  // namespace chasles
