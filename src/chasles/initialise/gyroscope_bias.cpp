#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <Eigen/Geometry>

#include <chasles/initialise/gyroscope_bias.hpp>
#include <chasles/lie/small_matrices.hpp>

namespace chasles {
namespace {

constexpr std::array kSteps{1, 2, 4, 8};  // keyframes between both of a pair
constexpr int kFewestMatches = 6;
constexpr std::size_t kPairHypotheses = 24;  // for a pair's direction
// Uncertainty of the bias in each pass [rad/s]; it limits the error of the rays.
constexpr std::array kUncertainties{0.1, 0.03, 0.01, 0.003, 0.001};
constexpr double kGate = 3;  // standard deviations

// Attitude of a keyframe against the first, and its derivative by the bias: R(b + d) = Exp(D d) R.
struct Attitude {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity(), D = Eigen::Matrix3d::Zero();
};

std::vector<Attitude> attitudes(const MotionWindow& window, const Eigen::Vector3d& bias) {
  std::vector<Attitude> result(1);
  for (const auto& intervals : window.intervals) {
    Attitude at = result.back();
    for (const ImuInterval& i : intervals) {
      const Eigen::Vector3d phi = (i.angular_rate_imu - bias) * i.tau;
      at.D -= i.tau * at.R * so3::left_jacobian(phi);
      at.R = at.R * so3::exp(phi);
    }
    result.push_back(at);
  }
  return result;
}

// The same track in two keyframes of one camera.
struct Match {
  const PlaneView *first = nullptr, *second = nullptr;
};
struct Pair {
  int first = 0, second = 0;
  double seconds = 0;
  std::vector<Match> matches;
};

std::vector<Pair> pairs_of(const MotionWindow& window) {
  std::vector<Pair> pairs;
  const int count = static_cast<int>(window.times.size());
  for (const int step : kSteps) {
    for (int k = 0; k + step < count; ++k) {
      const auto a = static_cast<std::size_t>(k), b = static_cast<std::size_t>(k + step);
      pairs.push_back({.first = k,
                       .second = k + step,
                       .seconds = to_seconds(window.times[b] - window.times[a]),
                       .matches = {}});
    }
  }
  const auto view_of = [](const PlaneTrack& track, int keyframe, int camera) {
    const auto found = std::ranges::find_if(
        track, [&](const PlaneView& v) { return v.keyframe == keyframe && v.camera == camera; });
    return found == track.end() ? nullptr : &*found;
  };
  for (Pair& pair : pairs) {
    for (const PlaneTrack& track : window.tracks) {
      for (const PlaneView& view : track) {
        if (view.keyframe != pair.first) continue;
        const PlaneView* other = view_of(track, pair.second, view.camera);
        if (other) pair.matches.push_back({&view, other});
      }
    }
  }
  return pairs;
}

// The residual of a match at the present attitudes.
struct Normal {
  Eigen::Vector3d u, v, n;  // rays and their normal, in the axes of the first keyframe
  double sigma = 0;         // of a ray
};

std::vector<Normal> normals(const Pair& pair, const std::vector<Attitude>& at) {
  std::vector<Normal> result;
  for (const Match& m : pair.matches) {
    Normal normal{.u = at[static_cast<std::size_t>(pair.first)].R * m.first->ray_imu,
                  .v = at[static_cast<std::size_t>(pair.second)].R * m.second->ray_imu,
                  .n = {},
                  .sigma = m.first->angle_sigma};
    normal.n = normal.u.cross(normal.v);
    result.push_back(normal);
  }
  return result;
}

// Standard deviation of t . n. A ray along t has no information, and must not cause a division by
// zero.
double ray_sigma(const Normal& m, const Eigen::Vector3d& t) {
  return m.sigma * std::sqrt(m.u.cross(t).squaredNorm() + m.v.cross(t).squaredNorm() + 1e-4);
}

double residual(const Normal& m, const Eigen::Vector3d& t) { return t.dot(m.n) / ray_sigma(m, t); }

// The direction of the translation: among cross products of two normals, the one that agrees with
// most. Zero if there is none.
Eigen::Vector3d best_direction(const std::vector<Normal>& normals, double gate) {
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double least = std::numeric_limits<double>::infinity();
  const std::size_t n = normals.size();
  for (std::size_t h = 0; h < kPairHypotheses; ++h) {
    const std::size_t a = (7 * h + 3) % n, b = (a + 1 + (13 * h + h / 3) % (n - 1)) % n;
    const Eigen::Vector3d t = normals[a].n.cross(normals[b].n);
    if (!(t.norm() > 1e-14)) continue;
    const Eigen::Vector3d unit = t.normalized();
    double cost = 0;
    for (const Normal& m : normals) {
      cost += std::min(std::pow(residual(m, unit), 2), gate * gate);
    }
    if (!(cost < least)) continue;
    least = cost;
    best = unit;
  }
  return best;
}

double gate_of(const Pair& pair, const Normal& normal, double uncertainty) {
  return kGate * std::sqrt(1 + std::pow(uncertainty * pair.seconds / normal.sigma, 2) / 2);
}

// The normal equations of a pair for the bias; the two unknowns of its direction are eliminated.
struct BiasEquations {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
};
BiasEquations equations(const Pair& pair, const std::vector<Attitude>& at, double uncertainty) {
  BiasEquations e;
  if (pair.matches.size() < kFewestMatches) return e;
  const std::vector<Normal> all = normals(pair, at);
  const double gate = gate_of(pair, all.front(), uncertainty);
  const Eigen::Vector3d t = best_direction(all, gate);
  if (t.isZero()) return e;
  Eigen::Matrix<double, 3, 2> tangent;
  tangent.col(0) = t.unitOrthogonal();
  tangent.col(1) = t.cross(tangent.col(0));
  const Eigen::Matrix3d& Du = at[static_cast<std::size_t>(pair.first)].D;
  const Eigen::Matrix3d& Dv = at[static_cast<std::size_t>(pair.second)].D;
  Eigen::Matrix<double, 5, 5> H = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 5, 1> b = Eigen::Matrix<double, 5, 1>::Zero();
  for (const Normal& m : all) {
    const double s = ray_sigma(m, t), r = t.dot(m.n) / s;
    if (std::abs(r) > gate) continue;
    Eigen::Matrix<double, 5, 1> J;
    const Eigen::Matrix3d d_bias = hat(m.v) * hat(m.u) * Du - hat(m.u) * hat(m.v) * Dv;
    J.head<3>() = d_bias.transpose() * t / s;
    J.tail<2>() = tangent.transpose() * m.n / s;
    H += J * J.transpose();
    b -= J * r;
  }
  H.diagonal().tail<2>().array() += 1e-9 + 1e-6 * H.diagonal().tail<2>().sum();
  const Eigen::Matrix<double, 2, 3> eliminated =
      H.bottomRightCorner<2, 2>().inverse() * H.bottomLeftCorner<2, 3>();
  e.H = H.topLeftCorner<3, 3>() - H.topRightCorner<3, 2>() * eliminated;
  e.b = b.head<3>() - eliminated.transpose() * b.tail<2>();
  return e;
}

}  // namespace

Eigen::Vector3d gyroscope_bias(const MotionWindow& window, double prior_sigma) {
  const std::vector<Pair> pairs = pairs_of(window);
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
  const double prior = 1 / (prior_sigma * prior_sigma);
  for (const double uncertainty : kUncertainties) {
    const std::vector<Attitude> at = attitudes(window, bias);
    Eigen::Matrix3d H = prior * Eigen::Matrix3d::Identity();
    Eigen::Vector3d b = -prior * bias;
    for (const Pair& pair : pairs) {
      const BiasEquations e = equations(pair, at, std::min(uncertainty, prior_sigma));
      H += e.H;
      b += e.b;
    }
    bias += solve_symmetric(H, b);
  }
  return bias;
}

void drop_mismatched(MotionWindow& window, const Eigen::Vector3d& bias) {
  const std::vector<Attitude> at = attitudes(window, bias);
  // Pairs with a larger distance between keyframes count more, because a track that drifts agrees
  // between neighbours.
  std::map<const PlaneView*, int> votes;
  for (const Pair& pair : pairs_of(window)) {
    if (pair.matches.size() < kFewestMatches) continue;
    const std::vector<Normal> all = normals(pair, at);
    const double gate = gate_of(pair, all.front(), kUncertainties.back());
    const Eigen::Vector3d t = best_direction(all, gate);
    const int weight = pair.second - pair.first;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const int vote = std::abs(residual(all[i], t)) < gate + 1 ? weight : -weight;
      votes[pair.matches[i].first] += vote;
      votes[pair.matches[i].second] += vote;
    }
  }
  for (PlaneTrack& track : window.tracks) {
    PlaneTrack kept;
    for (const PlaneView& view : track) {
      const auto found = votes.find(&view);
      if (found == votes.end() || found->second >= 0) kept.push_back(view);
    }
    track = std::move(kept);
  }
  std::erase_if(window.tracks, [](const PlaneTrack& track) {
    return track.size() < 3 || track.back().keyframe < track.front().keyframe + 2;
  });
}

}  // namespace chasles
