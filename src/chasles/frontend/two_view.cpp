#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include <chasles/base/vector_clones.hpp>
#include <chasles/frontend/two_view.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr std::size_t kMinPairs = 8;
// At most; with 30 % outliers, all 60 are bad with probability 1e-17.
constexpr int kSamples = 60, kRotationSamples = 60, kPoseSamples = 80;
constexpr double kMinAgreement = 0.3;      // of the pairs, for a decision
constexpr double kSuspectAgreement = 0.5;  // below it, a trusted rotation is suspect
constexpr double kTrustedSigma = 5e-3, kGuessSigma = 0.1;  // of the prior rotation [rad]

/// splitmix64 (Steele, Lea, Flood 2014): the same numbers on all platforms.
class Samples {
 public:
  explicit Samples(std::uint64_t seed) : state_(seed) {}

  /// Two different numbers below n.
  std::pair<std::size_t, std::size_t> draw(std::size_t n) {
    const std::size_t first = next() % n, other = next() % (n - 1);
    return {first, other + (other >= first ? 1 : 0)};
  }

 private:
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }

  std::uint64_t state_;
};

/// Samples of `size` pairs after which, with probability 1 - 1e-9, one of them had only inliers.
/// `cost` is a sum of truncated distances of `count` pairs: each outlier has `limit`, so that the
/// share of the inliers is at least what it leaves.
int samples_needed(double cost, double limit, std::size_t count, int size) {
  const double inliers = 1 - cost / (limit * static_cast<double>(count));
  const double good = std::pow(std::max(inliers, 0.0), size);
  if (!(good > 1e-6)) return std::numeric_limits<int>::max();
  if (!(good < 1 - 1e-9)) return 1;
  return static_cast<int>(std::ceil(std::log(1e-9) / std::log1p(-good)));
}

/// Both distances of a ray, for t_now and for -t_now.
struct Distances {
  double forward, backward;
};

Distances distances(const Eigen::Vector3d& r, const Eigen::Vector3d& f, const Eigen::Vector3d& t) {
  const Eigen::Vector3d move = f - r;
  const double turned = move.norm();
  const Eigen::Vector3d normal = t.cross(r);
  const double sine = normal.norm();
  if (!(sine > 1e-9)) return {turned, turned};
  const double off_plane = std::abs(f.dot(normal)) / sine;
  const bool towards = move.dot(t - t.dot(r) * r) > 0;
  return {towards ? off_plane : turned, towards ? turned : off_plane};
}

std::vector<RayPair> rotated(const std::vector<RayPair>& pairs, const Eigen::Matrix3d& now_R_last) {
  std::vector<RayPair> result = pairs;
  for (RayPair& pair : result) pair.last = now_R_last * pair.last;
  return result;
}

/// Pairs of rays, component by component, for loops over vectors. Pairs that fill the last vector
/// have no distance to any motion.
struct RayColumns {
  static constexpr std::size_t kLanes = 8;

  explicit RayColumns(const std::vector<RayPair>& turned) {
    const std::size_t count = (turned.size() + kLanes - 1) / kLanes * kLanes;
    for (auto* column : {&r_x, &r_y, &r_z, &f_x, &f_y, &f_z, &along, &turned_squared}) {
      column->assign(count, 0);
    }
    for (std::size_t i = 0; i < turned.size(); ++i) {
      const Eigen::Vector3d &r = turned[i].last, &f = turned[i].now;
      r_x[i] = r.x(), r_y[i] = r.y(), r_z[i] = r.z();
      f_x[i] = f.x(), f_y[i] = f.y(), f_z[i] = f.z();
      along[i] = (f - r).dot(r);
      turned_squared[i] = (f - r).squaredNorm();
    }
  }
  std::vector<double> r_x, r_y, r_z, f_x, f_y, f_z;
  std::vector<double> along, turned_squared;  // f - r along r, and its squared length
};

/// Sums of truncated squared distances, for t_now and for -t_now.
struct DirectionCosts {
  double forward = 0, backward = 0;
  double lower() const { return std::min(forward, backward); }
};

/// distances() of all pairs, squared. It ends where both sums have reached `enough`.
CHASLES_VECTOR_CLONES
DirectionCosts direction_costs(const RayColumns& rays, const Eigen::Vector3d& t, double limit,
                               double enough) {
  constexpr std::size_t kLanes = RayColumns::kLanes;
  constexpr double kLeastSine = 1e-18;  // squared
  const double t_x = t.x(), t_y = t.y(), t_z = t.z();
  const double *r_x = rays.r_x.data(), *r_y = rays.r_y.data(), *r_z = rays.r_z.data();
  const double *f_x = rays.f_x.data(), *f_y = rays.f_y.data(), *f_z = rays.f_z.data();
  const double *along = rays.along.data(), *turned_squared = rays.turned_squared.data();
  alignas(64) double forward[kLanes] = {}, backward[kLanes] = {};
  DirectionCosts costs;
  for (std::size_t first = 0; first < rays.r_x.size(); first += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::size_t i = first + lane;
      const double n_x = t_y * r_z[i] - t_z * r_y[i], n_y = t_z * r_x[i] - t_x * r_z[i],
                   n_z = t_x * r_y[i] - t_y * r_x[i];
      const double sine = n_x * n_x + n_y * n_y + n_z * n_z;
      const double off = f_x[i] * n_x + f_y[i] * n_y + f_z[i] * n_z;
      const double t_r = t_x * r_x[i] + t_y * r_y[i] + t_z * r_z[i];
      const double towards = t_x * f_x[i] + t_y * f_y[i] + t_z * f_z[i] - t_r - t_r * along[i];
      const double turned = turned_squared[i] < limit ? turned_squared[i] : limit;
      const double to_plane = sine > kLeastSine ? off * off / sine : turned;
      const double plane = to_plane < limit ? to_plane : limit;
      forward[lane] += towards > 0 ? plane : turned;
      backward[lane] += towards > 0 ? turned : plane;
    }
    if (first % (4 * kLanes) != 0 && first + kLanes < rays.r_x.size()) continue;
    costs = {};
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      costs.forward += forward[lane];
      costs.backward += backward[lane];
    }
    if (costs.lower() >= enough) break;
  }
  return costs;
}

/// The direction with the lowest sum of truncated squared distances.
Eigen::Vector3d best_direction(const std::vector<RayPair>& turned, double threshold, int draws,
                               Samples& samples) {
  const double limit = threshold * threshold;
  const RayColumns rays(turned);
  Eigen::Vector3d best = Eigen::Vector3d::UnitZ();
  double best_cost = std::numeric_limits<double>::infinity();
  int enough = draws;
  for (int i = 0; i < std::min(draws, enough); ++i) {
    const auto [a, b] = samples.draw(turned.size());
    const Eigen::Vector3d cross =
        turned[a].last.cross(turned[a].now).cross(turned[b].last.cross(turned[b].now));
    const double norm = cross.norm();
    if (!(norm > 1e-14)) continue;
    const Eigen::Vector3d t = cross / norm;
    const DirectionCosts costs = direction_costs(rays, t, limit, best_cost);
    if (costs.lower() >= best_cost) continue;
    best_cost = costs.lower();
    enough = samples_needed(best_cost, limit, turned.size(), 2);
    best = costs.forward <= costs.backward ? t : Eigen::Vector3d(-t);
  }
  return best;
}

/// The rotation that best maps two rays to two others: axes from their sum, difference and cross
/// product.
std::optional<Eigen::Matrix3d> rotation_of(const RayPair& a, const RayPair& b) {
  const auto axes = [](const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
    Eigen::Matrix3d result;
    result.col(0) = (u + v).normalized();
    result.col(1) = u.cross(v).normalized();
    result.col(2) = result.col(0).cross(result.col(1));
    return result;
  };
  if (a.last.cross(b.last).norm() < 0.05 || a.now.cross(b.now).norm() < 0.05) return std::nullopt;
  return axes(a.now, b.now) * axes(a.last, b.last).transpose();
}

/// The pure rotation that explains most tracks. Parallax counts as noise, hence the wide limit.
Eigen::Matrix3d best_rotation(const std::vector<RayPair>& pairs, const TwoViewPrior& prior,
                              Samples& samples) {
  const double limit = std::pow(10 * prior.threshold, 2);
  const auto cost = [&](const Eigen::Matrix3d& R) {
    double sum = 0;
    for (const RayPair& p : pairs) sum += std::min(limit, (p.now - R * p.last).squaredNorm());
    return sum;
  };
  Eigen::Matrix3d best = prior.now_R_last;
  double best_cost = cost(best);
  for (int i = 0; i < kRotationSamples; ++i) {
    const auto [a, b] = samples.draw(pairs.size());
    const std::optional<Eigen::Matrix3d> R = rotation_of(pairs[a], pairs[b]);
    if (!R) continue;
    const double sum = cost(*R);
    if (sum >= best_cost) continue;
    best_cost = sum;
    best = *R;
  }
  return best;
}

/// One Gauss-Newton step in (rotation, direction): residual f . (t x r) / |t x r|, with a prior on
/// the rotation. The direction moves in the plane perpendicular to t.
void refine(const std::vector<RayPair>& pairs, const TwoViewPrior& prior,
            const Eigen::Matrix3d& R_prior, double scale, TwoView& motion) {
  const Eigen::Vector3d& t = motion.t_now;
  const Eigen::Vector3d u = t.unitOrthogonal(), v = t.cross(u);
  const double sigma = prior.trusted ? kTrustedSigma : kGuessSigma;
  const double noise = prior.threshold / 2;
  using Vector5 = Eigen::Matrix<double, 5, 1>;
  Eigen::Matrix<double, 5, 5> H = Eigen::Matrix<double, 5, 5>::Zero();
  Vector5 b = Vector5::Zero();
  for (const RayPair& pair : pairs) {
    const Eigen::Vector3d r = motion.now_R_last * pair.last, &f = pair.now;
    const Eigen::Vector3d normal = t.cross(r), move = f - r;
    const double sine = normal.norm();
    if (sine < 0.02) continue;  // near the epipole every direction fits
    const double residual = f.dot(normal) / sine;
    const bool towards = move.dot(t - t.dot(r) * r) > 0;
    const double ratio = (towards ? residual : move.norm()) / scale;
    const double weight = 1 / (1 + ratio * ratio) / (noise * noise);
    const Eigen::Vector3d d_t = r.cross(f) / sine;
    Vector5 J;
    J << r.cross(f.cross(t)) / sine, d_t.dot(u), d_t.dot(v);
    H += weight * J * J.transpose();
    b -= weight * residual * J;
  }
  const Eigen::Vector3d from_prior = so3::log(motion.now_R_last * R_prior.transpose());
  H.diagonal().head<3>().array() += 1 / (sigma * sigma);
  b.head<3>() -= from_prior / (sigma * sigma);
  H.diagonal().tail<2>().array() += 1;
  const Vector5 step = solve_symmetric(H, b);
  if (!step.allFinite()) return;
  motion.now_R_last = so3::exp(step.head<3>()) * motion.now_R_last;
  motion.t_now = (t + u * step[3] + v * step[4]).normalized();
}

/// Sum of truncated squared distances of a motion.
double cost_of(const std::vector<RayPair>& pairs, const TwoView& motion, double threshold) {
  const double limit = threshold * threshold;
  double sum = 0;
  for (const RayPair& pair : pairs) {
    const double d = half_circle_distance(motion.now_R_last * pair.last, pair.now, motion.t_now);
    sum += std::min(limit, d * d);
  }
  return sum;
}

constexpr int kSampledTwice = 3;  // draws of two pairs

/// Without a gyroscope, parallax biases the best pure rotation. Starting from it, samples of six
/// pairs are solved for rotation and direction together. The motion with the most support is kept.
void search_both(const std::vector<RayPair>& pairs, const TwoViewPrior& prior, Samples& samples,
                 TwoView& motion) {
  const Eigen::Matrix3d R_start = motion.now_R_last;
  double best_cost = cost_of(pairs, motion, prior.threshold);
  TwoView best = motion;
  const double limit = prior.threshold * prior.threshold;
  int enough = samples_needed(best_cost, limit, pairs.size(), 2 * kSampledTwice);
  for (int i = 0; i < std::min(kPoseSamples, enough); ++i) {
    std::vector<RayPair> some;
    for (int k = 0; k < kSampledTwice; ++k) {
      const auto [a, b] = samples.draw(pairs.size());
      some.insert(some.end(), {pairs[a], pairs[b]});
    }
    TwoView trial = motion;
    trial.t_now = best_direction(rotated(some, R_start), 10 * prior.threshold, 8, samples);
    for (int step = 0; step < 8; ++step) {
      refine(some, prior, R_start, 10 * prior.threshold, trial);
    }
    const double cost = cost_of(pairs, trial, prior.threshold);
    if (cost >= best_cost) continue;
    best_cost = cost;
    enough = samples_needed(best_cost, limit, pairs.size(), 2 * kSampledTwice);
    best = trial;
  }
  motion = best;
}

/// Marks the inliers of the motion, and returns their share.
double mark(const std::vector<RayPair>& pairs, double threshold, TwoView& motion) {
  double agreeing = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector3d r = motion.now_R_last * pairs[i].last;
    motion.right[i] = half_circle_distance(r, pairs[i].now, motion.t_now) <= threshold ? 1 : 0;
    agreeing += motion.right[i];
  }
  return agreeing / static_cast<double>(pairs.size());
}

TwoView solve(const std::vector<RayPair>& pairs, const TwoViewPrior& prior) {
  TwoView motion{.now_R_last = prior.now_R_last, .right = std::vector<char>(pairs.size(), 1)};
  Samples samples(prior.seed);
  if (!prior.trusted) motion.now_R_last = best_rotation(pairs, prior, samples);
  motion.t_now =
      best_direction(rotated(pairs, motion.now_R_last), 2 * prior.threshold, kSamples, samples);
  if (!prior.trusted) search_both(pairs, prior, samples, motion);
  const Eigen::Matrix3d R_prior = motion.now_R_last;
  for (const double scale : {3.0, 2.0, 1.0, 0.5, 0.5}) {
    refine(pairs, prior, R_prior, scale * prior.threshold, motion);
  }
  return motion;
}

}  // namespace

double half_circle_distance(const Eigen::Vector3d& rotated_last, const Eigen::Vector3d& now,
                            const Eigen::Vector3d& t_now) {
  return distances(rotated_last, now, t_now).forward;
}

TwoView find_motion(const std::vector<RayPair>& pairs, const TwoViewPrior& prior) {
  TwoView motion{.now_R_last = prior.now_R_last, .right = std::vector<char>(pairs.size(), 1)};
  if (pairs.size() < kMinPairs) return motion;
  motion = solve(pairs, prior);
  double agreement = mark(pairs, prior.threshold, motion);
  if (prior.trusted && agreement < kSuspectAgreement) {
    TwoViewPrior guess = prior;
    guess.trusted = false;
    TwoView other = solve(pairs, guess);
    const double other_agreement = mark(pairs, prior.threshold, other);
    if (other_agreement > agreement) {
      motion = other;
      agreement = other_agreement;
    }
  }
  motion.decided = agreement >= kMinAgreement;
  if (!motion.decided) std::fill(motion.right.begin(), motion.right.end(), char{1});
  return motion;
}

}  // namespace chasles
