#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Geometry>

#include <chasles/base/median.hpp>
#include <chasles/check/gyroscope_turns.hpp>
#include <chasles/check/lens_fit.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr double kApartFrom = 0.1;  // between the beginnings of two intervals [s]
constexpr std::size_t kFewestOfLens = 20;
constexpr double kEdge = 0.95;         // share of the rays
constexpr double kSlack = 1.5e-3;      // of the rotation of an interval [rad]
constexpr double kLeastAngle = 3e-4;   // scale of a residual: a sixth of a pixel [rad]
constexpr double kSecondOfSigmas = 1;  // errors of tracks that share it are not independent [s]
constexpr int kMostLensSteps = 40;
constexpr double kLensConverged = 1e-4;
constexpr double kLongestLensStep = 0.2;  // of focal length and distortion
constexpr double kLeastFocal = 1 / 3.0, kMostFocalScale = 3;
constexpr double kNoTurn = 1e-9;
constexpr double kLeastLensScale = 0.1;

// The unknowns of all intervals: bias, rotation of the camera, gain, offset, and the lens.
constexpr int kGlobal = 11, kGainRow = 6, kOffsetRow = 7, kFocalRow = 8, kRadialRow = 9,
              kReadoutRow = 10;
// Of one interval: its rotation, and the direction of its translation.
constexpr int kLocal = 5;
using Global = Eigen::Matrix<double, kGlobal, 1>;
using Local = Eigen::Matrix<double, kLocal, 1>;
using Vector3 = Eigen::Vector3d;

struct LensUnknowns {
  Vector3 bias_cam;
  Eigen::Matrix3d cam_R_imu;
  double gain, offset, focal = 0, radial = 0, readout = 0;
};

// A ray with the errors of lens and readout undone, and its derivatives by focal, radial, readout.
// `scale`: of its angle, over the stated one.
struct MendedRay {
  Vector3 ray;
  Eigen::Matrix3d J;
  double scale = 1;
  Vector3 d_scale = Vector3::Zero();
};

MendedRay mended_ray(const Vector3& stated, double row, double stretch, const Vector3& rate_cam,
                     const LensUnknowns& x) {
  const double across = std::hypot(stated.x(), stated.y());
  const double angle = std::atan2(across, stated.z());
  const Eigen::Vector2d side =
      across > kNoTurn ? Eigen::Vector2d(stated.head<2>() / across) : Eigen::Vector2d(1, 0);
  const double by_focal = angle > kNoTurn ? stretch / angle : 1;
  const double right = angle * (1 + x.focal * by_focal + x.radial * angle * angle);
  const Vector3 ray(std::sin(right) * side.x(), std::sin(right) * side.y(), std::cos(right));
  const Vector3 outwards(std::cos(right) * side.x(), std::cos(right) * side.y(), -std::sin(right));
  const Vector3 turned = rate_cam.cross(ray) * row;
  MendedRay result{
      .ray = ray + x.readout * turned,
      .J = {},
      .scale = std::max(1 + x.focal * by_focal + x.radial * angle * angle, kLeastLensScale),
      .d_scale = {by_focal, angle * angle, 0}};
  result.J << outwards * angle * by_focal, outwards * (angle * angle * angle), turned;
  return result;
}

struct LensInterval {
  Time begin{}, end{};
  const std::vector<TwoRays>* pairs = nullptr;
  Vector3 slack = Vector3::Zero();  // Exp(slack) of the predicted second_R_first
  Vector3 t = Vector3::UnitX();
  bool started = false;  // t is known
};

// Normal equations of one interval.
struct LensEquations {
  Eigen::Matrix<double, kGlobal, kGlobal> A = Eigen::Matrix<double, kGlobal, kGlobal>::Zero();
  Eigen::Matrix<double, kGlobal, kLocal> M = Eigen::Matrix<double, kGlobal, kLocal>::Zero();
  Eigen::Matrix<double, kLocal, kLocal> L = Eigen::Matrix<double, kLocal, kLocal>::Zero();
  Global b = Global::Zero();
  Local c = Local::Zero();
};

struct LensRow {
  double angle = 0;
  Global global;
  Local local;
};

// What the gyroscope predicts for one interval, with its derivatives.
struct PredictedTurn {
  Eigen::Matrix3d second_R_first;
  Eigen::Matrix<double, 3, 8> J;  // of delta in Exp(delta) second_R_first, by bias ... offset
  Vector3 first_rate_cam, second_rate_cam;
};

PredictedTurn predicted_turn(const GyroscopeTurns& turns, const LensInterval& interval,
                             const LensUnknowns& x) {
  const Time begin = interval.begin + from_seconds(x.offset),
             end = interval.end + from_seconds(x.offset);
  const double seconds = to_seconds(interval.end - interval.begin);
  const Vector3 seen = x.cam_R_imu * turns.turn(begin, end);
  const Vector3 turn = x.gain * seen + seconds * x.bias_cam;
  const Vector3 first = x.gain * (x.cam_R_imu * turns.rate(begin)),
                second = x.gain * (x.cam_R_imu * turns.rate(end));
  PredictedTurn result{.second_R_first = so3::exp(interval.slack) * so3::exp(-turn),
                       .J = {},
                       .first_rate_cam = first,
                       .second_rate_cam = second};
  result.J << seconds * Eigen::Matrix3d::Identity(), -hat(x.gain * seen), seen, second - first;
  result.J = -so3::left_jacobian(-turn) * result.J;
  return result;
}

Eigen::Matrix<double, 3, 2> tangents(const Vector3& t) {
  Eigen::Matrix<double, 3, 2> B;
  B.col(0) = t.unitOrthogonal();
  B.col(1) = t.cross(B.col(0));
  return B;
}

// The fit over all intervals.
class LensProblem {
 public:
  LensProblem(const std::vector<SeenTwice>& seen, const std::vector<StampedRate>& gyroscope,
              const GyroscopeFit& start)
      : turns_(gyroscope),
        start_(start),
        x_{.bias_cam = start.bias_cam,
           .cam_R_imu = start.cam_R_imu,
           .gain = start.gain,
           .offset = start.offset} {
    const Time margin = from_seconds(std::abs(start.offset) + 0.1);
    for (const SeenTwice& two : seen) {
      if (!turns_.covers(two.begin - margin)) continue;
      if (!turns_.covers(two.end + margin)) continue;
      const bool near =
          !intervals_.empty() && to_seconds(two.begin - intervals_.back().begin) < kApartFrom;
      if (!near) intervals_.push_back({.begin = two.begin, .end = two.end, .pairs = &two.pairs});
    }
  }

  std::size_t intervals() const { return intervals_.size(); }
  const LensUnknowns& unknowns() const { return x_; }

  // One Gauss-Newton step; its size in units of the prior, or nothing where it fails.
  std::optional<double> step() {
    std::vector<LensEquations> all;
    Eigen::Matrix<double, kGlobal, kGlobal> A = prior();
    Global b = -prior() * from_prior();
    for (LensInterval& interval : intervals_) {
      all.push_back(equations(interval));
      const LensEquations& e = all.back();
      const Eigen::Matrix<double, kLocal, kGlobal> eliminated =
          solve_symmetric<kLocal, kGlobal>(e.L, e.M.transpose());
      A.noalias() += e.A - e.M * eliminated;
      b.noalias() += e.b - eliminated.transpose() * e.c;
    }
    Global step = solve_symmetric<kGlobal, 1>(A, b);
    if (!step.allFinite()) return std::nullopt;
    step *= std::min(1.0, kLongestLensStep / step.tail<3>().head<2>().cwiseAbs().maxCoeff());
    for (std::size_t i = 0; i < intervals_.size(); ++i) {
      const LensEquations& e = all[i];
      move(intervals_[i], solve_symmetric<kLocal, 1>(e.L, e.c - e.M.transpose() * step));
    }
    add(step);
    return step.tail<5>().cwiseAbs().maxCoeff();
  }

  // Standard deviations, from the scatter of seconds.
  Global sigmas() {
    Eigen::Matrix<double, kGlobal, kGlobal> A = prior();
    std::map<int, Global> gradients;
    for (LensInterval& interval : intervals_) {
      const LensEquations e = equations(interval);
      const Eigen::Matrix<double, kLocal, kGlobal> eliminated =
          solve_symmetric<kLocal, kGlobal>(e.L, e.M.transpose());
      A.noalias() += e.A - e.M * eliminated;
      const int second =
          static_cast<int>(to_seconds(interval.begin - intervals_.front().begin) / kSecondOfSigmas);
      auto [gradient, fresh] = gradients.try_emplace(second, Global::Zero());
      gradient->second += e.b - eliminated.transpose() * e.c;
    }
    Eigen::Matrix<double, kGlobal, kGlobal> middle =
        Eigen::Matrix<double, kGlobal, kGlobal>::Zero();
    for (const auto& [second, gradient] : gradients) middle += gradient * gradient.transpose();
    const Eigen::Matrix<double, kGlobal, kGlobal> P = inverse_symmetric(A);
    const auto n = static_cast<double>(gradients.size());
    return ((P * middle * P).diagonal() * (n / std::max(1.0, n - 1)))
        .cwiseMax(P.diagonal())
        .cwiseSqrt();
  }

  // Cauchy's, of all angles at one scale: that of an interval would make large ones cheap.
  double cost() const {
    double sum = 0, count = 0;
    for (const LensInterval& interval : intervals_) {
      const PredictedTurn turn = predicted_turn(turns_, interval, x_);
      const auto B = tangents(interval.t);
      for (const TwoRays& pair : *interval.pairs) {
        const double ratio = row(pair, turn, interval.t, B).angle / kLeastAngle;
        sum += std::log1p(ratio * ratio);
        ++count;
      }
    }
    return sum / count;
  }

  double edge() const {
    std::vector<double> angles;
    for (const LensInterval& interval : intervals_) {
      for (const TwoRays& pair : *interval.pairs) {
        angles.push_back(std::atan2(pair.first.head<2>().norm(), pair.first.z()));
      }
    }
    const auto nth = angles.begin() +
                     static_cast<std::ptrdiff_t>(kEdge * static_cast<double>(angles.size() - 1));
    std::nth_element(angles.begin(), nth, angles.end());
    return *nth;
  }

 private:
  // So weak that only what the tracks leave open follows it.
  static Eigen::Matrix<double, kGlobal, kGlobal> prior() {
    Global sigma;
    sigma << 0.1, 0.1, 0.1, 0.2, 0.2, 0.2, 0.3, 0.05, 0.5, 2, 0.05;
    return sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  }

  Global from_prior() const {
    Global d;
    d << x_.bias_cam - start_.bias_cam, Vector3::Zero(), x_.gain - start_.gain,
        x_.offset - start_.offset, x_.focal, x_.radial, x_.readout;
    return d;
  }

  void begin(LensInterval& interval, const PredictedTurn& turn) const {
    Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
    for (const TwoRays& pair : *interval.pairs) {
      const Vector3 n = (turn.second_R_first * pair.first).cross(pair.second);
      M += n * n.transpose() / (n.squaredNorm() + 1e-6);
    }
    interval.t = symmetric_eigen(M).vectors.col(0);
    interval.started = true;
  }

  LensEquations equations(LensInterval& interval) const {
    const PredictedTurn turn = predicted_turn(turns_, interval, x_);
    if (!interval.started) begin(interval, turn);
    const auto B = tangents(interval.t);
    std::vector<LensRow> rows;
    std::vector<double> sizes;
    for (const TwoRays& pair : *interval.pairs) {
      rows.push_back(row(pair, turn, interval.t, B));
      sizes.push_back(std::abs(rows.back().angle));
    }
    const double scale = std::max(kLeastAngle, 1.5 * median(std::move(sizes)));
    LensEquations e;
    for (const LensRow& r : rows) {
      const double ratio = r.angle / scale;
      const double weight = 1 / ((1 + ratio * ratio) * scale * scale);
      e.A.noalias() += weight * r.global * r.global.transpose();
      e.M.noalias() += weight * r.global * r.local.transpose();
      e.L.noalias() += weight * r.local * r.local.transpose();
      e.b.noalias() -= weight * r.angle * r.global;
      e.c.noalias() -= weight * r.angle * r.local;
    }
    e.L.diagonal().head<3>().array() += 1 / (kSlack * kSlack);
    e.L.diagonal().tail<2>().array() += 1;  // without a translation its direction is open
    e.c.head<3>() -= interval.slack / (kSlack * kSlack);
    return e;
  }

  LensRow row(const TwoRays& pair, const PredictedTurn& turn, const Vector3& t,
              const Eigen::Matrix<double, 3, 2>& B) const {
    const MendedRay first = mended_ray(pair.first, pair.first_row, pair.first_stretch,
                                       turn.first_rate_cam, x_),
                    second = mended_ray(pair.second, pair.second_row, pair.second_stretch,
                                        turn.second_rate_cam, x_);
    const Vector3 a = turn.second_R_first * first.ray;
    const double sine = std::max(t.cross(a).norm(), 1e-2);
    const Vector3 by_a = second.ray.cross(t) / sine, by_b = t.cross(a) / sine;
    const Vector3 by_turn = a.cross(by_a);
    LensRow r{.angle = t.dot(a.cross(second.ray)) / sine, .global = {}, .local = {}};
    r.global.head<8>() = turn.J.transpose() * by_turn;
    r.global.tail<3>() =
        (turn.second_R_first * first.J).transpose() * by_a + second.J.transpose() * by_b;
    r.local.head<3>() = by_turn;
    r.local.tail<2>() = B.transpose() * a.cross(second.ray) / sine;
    // In stated angles, as the pixels' noise is: a lens with smaller angles has no smaller errors.
    r.angle /= second.scale;
    r.global /= second.scale;
    r.local /= second.scale;
    r.global.tail<3>() -= r.angle / second.scale * second.d_scale;
    return r;
  }

  static void move(LensInterval& interval, const Local& step) {
    interval.slack += step.head<3>();
    interval.t = (interval.t + tangents(interval.t) * step.tail<2>()).normalized();
  }

  void add(const Global& step) {
    x_.bias_cam += step.head<3>();
    x_.cam_R_imu = so3::exp(step.segment<3>(3)) * x_.cam_R_imu;
    x_.gain += step[kGainRow];
    x_.offset += step[kOffsetRow];
    x_.focal += step[kFocalRow];
    x_.radial += step[kRadialRow];
    x_.readout += step[kReadoutRow];
  }

  GyroscopeTurns turns_;
  GyroscopeFit start_;
  LensUnknowns x_;
  std::vector<LensInterval> intervals_;
};

}  // namespace

bool Measured::differs(double expected, double limit) const {
  constexpr double kSigmasToDiffer = 5;
  return std::abs(value - expected) > std::max(limit, kSigmasToDiffer * sigma);
}

Measured LensFit::radial_at_edge() const {
  return {.value = radial.value * edge * edge, .sigma = radial.sigma * edge * edge};
}

std::vector<SeenTwice> mended(const std::vector<SeenTwice>& seen, const LensFit& lens) {
  const LensUnknowns x{.bias_cam = Vector3::Zero(),
                       .cam_R_imu = Eigen::Matrix3d::Identity(),
                       .gain = 1,
                       .offset = 0,
                       .focal = lens.focal.value,
                       .radial = lens.radial.value};
  std::vector<SeenTwice> result = seen;
  for (SeenTwice& two : result) {
    for (TwoRays& pair : two.pairs) {
      const MendedRay first = mended_ray(pair.first, 0, pair.first_stretch, Vector3::Zero(), x),
                      second = mended_ray(pair.second, 0, pair.second_stretch, Vector3::Zero(), x);
      pair.first = first.ray;
      pair.second = second.ray;
      pair.first_stretch *= first.scale;
      pair.second_stretch *= second.scale;
    }
  }
  return result;
}

std::vector<SeenTwice> unrolled(const std::vector<SeenTwice>& seen,
                                const std::vector<StampedRate>& gyroscope, const LensFit& lens) {
  const GyroscopeTurns turns(gyroscope);
  const auto at_middle = [&](const Vector3& ray, double row, const Vector3& rate_cam) {
    return Vector3((ray + lens.readout.value * row * rate_cam.cross(ray)).normalized());
  };
  const auto rate_at = [&](Time time) {
    const Time at = std::clamp(time + from_seconds(lens.offset.value), gyroscope.front().time,
                               gyroscope.back().time);
    return Vector3(lens.gain.value * (lens.cam_R_imu * turns.rate(at)));
  };
  std::vector<SeenTwice> result = seen;
  for (SeenTwice& two : result) {
    const Vector3 first = rate_at(two.begin), second = rate_at(two.end);
    for (TwoRays& pair : two.pairs) {
      pair.first = at_middle(pair.first, pair.first_row, first);
      pair.second = at_middle(pair.second, pair.second_row, second);
    }
  }
  return result;
}

std::optional<LensFit> fit_lens(const std::vector<SeenTwice>& seen,
                                const std::vector<StampedRate>& gyroscope,
                                const GyroscopeFit& start) {
  if (gyroscope.size() < 3 || start.mirrored || start.gain < 0.3 || start.gain > 3) {
    return std::nullopt;
  }
  LensProblem problem(seen, gyroscope, start);
  if (problem.intervals() < kFewestOfLens) return std::nullopt;
  bool converged = false;
  for (int k = 0; k < kMostLensSteps && !converged; ++k) {
    const std::optional<double> step = problem.step();
    if (!step) return std::nullopt;
    converged = *step < kLensConverged;
  }
  if (!converged) return std::nullopt;
  const double scale = 1 + problem.unknowns().focal;
  if (scale < kLeastFocal || scale > kMostFocalScale) return std::nullopt;
  const Global sigmas = problem.sigmas();
  if (!sigmas.allFinite()) return std::nullopt;
  const LensUnknowns& x = problem.unknowns();
  return LensFit{.focal = {x.focal, sigmas[kFocalRow]},
                 .radial = {x.radial, sigmas[kRadialRow]},
                 .readout = {x.readout, sigmas[kReadoutRow]},
                 .gain = {x.gain, sigmas[kGainRow]},
                 .offset = {x.offset, sigmas[kOffsetRow]},
                 .edge = problem.edge(),
                 .intervals = problem.intervals(),
                 .cam_R_imu = x.cam_R_imu,
                 .bias_cam = x.bias_cam,
                 .cost = problem.cost()};
}

}  // namespace chasles
