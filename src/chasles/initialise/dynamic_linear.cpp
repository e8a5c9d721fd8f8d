#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Geometry>

#include <chasles/initialise/dynamic_linear.hpp>
#include <chasles/lie/small_matrices.hpp>

namespace chasles {
namespace {

using Unknown = Eigen::Matrix<double, 6, 1>;  // v, g
using Matrix36d = Eigen::Matrix<double, 3, 6>;

constexpr std::size_t kTracksOfSubset = 8;
constexpr std::size_t kSubsets = 40;
constexpr double kParallaxOverNoise = 3;
constexpr double kFits = 6;  // rms of a track
constexpr int kReweightings = 8;
constexpr double kLeastRange = 0.1;  // [m]

// A view in the axes of the first keyframe: from c = t v + t^2/2 g + known, along u.
struct Ray {
  double t = 0;
  Eigen::Vector3d known, u;
  double sigma = 0;
  double weight = 0;  // 1 / (sigma range)^2

  Matrix36d T() const {
    Matrix36d T = Matrix36d::Zero();
    T.leftCols<3>().diagonal().setConstant(t);
    T.rightCols<3>().diagonal().setConstant(t * t / 2);
    return T;
  }
};
using Rays = std::vector<Ray>;

// A track's equations with its point eliminated: S y = s, x = x0 + X y.
struct TrackEquations {
  Matrix6d S = Matrix6d::Zero();
  Unknown s = Unknown::Zero();
  Eigen::Vector3d x0;
  Matrix36d X;
};

std::vector<Rays> rays_of(const MotionWindow& window, const std::vector<Preintegration>& d) {
  std::vector<InertialState> at(1);
  std::vector<double> seconds(1, 0);
  for (const Preintegration& p : d) {
    at.push_back(moved(at.back(), p, Eigen::Vector3d::Zero()));
    seconds.push_back(seconds.back() + p.seconds);
  }
  std::vector<Rays> tracks;
  for (const PlaneTrack& track : window.tracks) {
    Rays& rays = tracks.emplace_back();
    for (const PlaneView& view : track) {
      const auto k = static_cast<std::size_t>(view.keyframe);
      const SE3& imu_T_cam = window.imu_T_cam[static_cast<std::size_t>(view.camera)];
      const Eigen::Vector3d pushed =
          view.delay * view.delay / 2 * window.readouts[k].force + view.imu_R_line * imu_T_cam.p;
      rays.push_back({.t = seconds[k] + view.delay,
                      .known = at[k].world_T_imu * pushed + view.delay * at[k].v_world,
                      .u = at[k].world_T_imu.R * view.ray_imu,
                      .sigma = view.angle_sigma,
                      .weight = 1 / (view.angle_sigma * view.angle_sigma)});
    }
  }
  return tracks;
}

// The noise e of a ray adds |e|^2 |d|^2 to |(1 - u u^T) d|^2. This favours near points and low
// speeds: where the motion determines the scale weakly, the scale would collapse. Therefore the
// expectation of this term, 2 sigma^2 (u . d)^2, is subtracted. A track whose parallax does not
// exceed the noise then has no weight.
TrackEquations equations(const Rays& rays) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero(), noise = Eigen::Matrix3d::Zero();
  Eigen::Vector3d a = Eigen::Vector3d::Zero();
  Matrix36d B = Matrix36d::Zero();
  TrackEquations e;
  for (const Ray& ray : rays) {
    const Eigen::Matrix3d along = ray.u * ray.u.transpose();
    A += ray.weight * (Eigen::Matrix3d::Identity() - along);
    noise += 2 * ray.sigma * ray.sigma * ray.weight * along;
  }
  const double least = symmetric_eigen(A).values[0];
  const double correction = least > kParallaxOverNoise * noise.trace() ? 1 : 0;
  A -= correction * noise;
  A.diagonal().array() += 1e-9 * A.trace();
  for (const Ray& ray : rays) {
    const double less = 1 + correction * 2 * ray.sigma * ray.sigma;
    const Eigen::Matrix3d across =
        ray.weight * (Eigen::Matrix3d::Identity() - less * ray.u * ray.u.transpose());
    const Matrix36d T = ray.T();
    B += across * T;
    a += across * ray.known;
    e.S += T.transpose() * across * T;
    e.s -= T.transpose() * (across * ray.known);
  }
  Eigen::Matrix<double, 3, 7> solved;
  solved << a, B;
  solved = solve_symmetric(A, solved);
  e.x0 = solved.col(0);
  e.X = solved.rightCols<6>();
  e.S -= B.transpose() * e.X;
  e.s += B.transpose() * e.x0;
  e.S *= correction;
  e.s *= correction;
  return e;
}

// Angle between a view's ray and its track's point, in standard deviations; infinite behind the
// camera.
double residual(const Ray& ray, const Eigen::Vector3d& x, const Unknown& y) {
  const Eigen::Vector3d to = x - ray.T() * y - ray.known;
  const double along = ray.u.dot(to);
  if (!(along > 0)) return std::numeric_limits<double>::infinity();
  return (to - along * ray.u).norm() / (along * ray.sigma);
}

double truncated_cost(const Rays& rays, const TrackEquations& e, const Unknown& y) {
  const Eigen::Vector3d x = e.x0 + e.X * y;
  double cost = 0;
  for (const Ray& ray : rays) {
    const double r = std::min(residual(ray, x, y), kTruncation);
    cost += r * r;
  }
  return cost;
}

// The deterministic subset number h of all tracks, each at most once.
std::vector<std::size_t> subset(std::size_t h, std::size_t tracks) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; chosen.size() < kTracksOfSubset; ++i) {
    std::size_t next = (h * 17 + i * (11 + 2 * h) + i * i * 3) % tracks;
    while (std::ranges::find(chosen, next) != chosen.end()) next = (next + 1) % tracks;
    chosen.push_back(next);
  }
  return chosen;
}

std::optional<Unknown> best_subset(const std::vector<Rays>& tracks,
                                   const std::vector<TrackEquations>& equations) {
  std::vector<std::size_t> all(tracks.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  std::optional<Unknown> best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t h = 0; h < kSubsets; ++h) {
    Matrix6d S = Matrix6d::Zero();
    Unknown s = Unknown::Zero();
    for (const std::size_t i : h == 0 ? all : subset(h, tracks.size())) {
      S += equations[i].S;
      s += equations[i].s;
    }
    const Unknown y = solve_symmetric(S, s);
    if (!y.allFinite()) continue;
    double cost = 0;
    for (std::size_t i = 0; i < tracks.size() && cost < least; ++i) {
      cost += truncated_cost(tracks[i], equations[i], y);
    }
    if (!(cost < least)) continue;
    least = cost;
    best = y;
  }
  return best;
}

// Weights by range and by the agreement of each view.
void reweight(Rays& rays, const TrackEquations& e, const Unknown& y) {
  const Eigen::Vector3d x = e.x0 + e.X * y;
  for (Ray& ray : rays) {
    const double r = residual(ray, x, y);
    const double range = std::max((x - ray.T() * y - ray.known).norm(), kLeastRange);
    const double trust = r < kTruncation ? 1 / std::max(1.0, r / 2) : 1e-6;
    ray.weight = trust / std::pow(ray.sigma * range, 2);
  }
}

double truncated_cost(const std::vector<Rays>& tracks, const std::vector<TrackEquations>& each,
                      const Unknown& y) {
  double cost = 0;
  for (std::size_t k = 0; k < tracks.size(); ++k) cost += truncated_cost(tracks[k], each[k], y);
  return cost;
}

// A motion, its cost, and the equations of all tracks that fit it.
struct Solution {
  Matrix6d S = Matrix6d::Zero();
  Unknown s = Unknown::Zero();
  Unknown y = Unknown::Zero();
  double cost = 0;
};
Solution equations_at(const std::vector<Rays>& tracks, const std::vector<TrackEquations>& each,
                      const Unknown& y) {
  Solution solution{.y = y};
  for (std::size_t k = 0; k < tracks.size(); ++k) {
    const double squares = truncated_cost(tracks[k], each[k], y);
    solution.cost += squares;
    if (!(squares < kFits * kFits * static_cast<double>(tracks[k].size()))) continue;
    solution.S += each[k].S;
    solution.s += each[k].s;
  }
  return solution;
}

// The first point with a lower cost on the line to the solution of the weighted equations. The
// weights differ from the costs, and S need not be positive after the subtraction of the noise.
std::optional<Unknown> towards(const std::vector<Rays>& tracks,
                               const std::vector<TrackEquations>& each, const Solution& here,
                               const Unknown& there) {
  for (const double part : {1.0, 0.5, 0.25, 0.1}) {
    const Unknown y = here.y + part * (there - here.y);
    if (truncated_cost(tracks, each, y) < here.cost) return y;
  }
  return std::nullopt;
}

// The minimum of y^T S y - 2 s^T y for a given |gravity|.
Unknown on_sphere(const Matrix6d& S, const Unknown& s, Unknown y, double gravity) {
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d down = y.tail<3>().normalized();
    y.tail<3>() = gravity * down;
    Eigen::Matrix<double, 6, 5> J = Eigen::Matrix<double, 6, 5>::Zero();
    J.topLeftCorner<3, 3>().setIdentity();
    J.block<3, 1>(3, 3) = down.unitOrthogonal();
    J.block<3, 1>(3, 4) = down.cross(down.unitOrthogonal());
    const Eigen::Matrix<double, 5, 5> across = J.transpose() * S * J;
    const Eigen::Matrix<double, 5, 1> right = J.transpose() * (s - S * y);
    y += J * solve_symmetric(across, right);
  }
  y.tail<3>() = gravity * y.tail<3>().normalized();
  return y;
}

}  // namespace

std::optional<LinearMotion> linear_motion(const MotionWindow& window,
                                          const std::vector<Preintegration>& between,
                                          double gravity) {
  if (window.tracks.size() < kTracksOfSubset) return std::nullopt;
  std::vector<Rays> tracks = rays_of(window, between);
  std::vector<TrackEquations> each;
  for (const Rays& rays : tracks) each.push_back(equations(rays));
  const std::optional<Unknown> first = best_subset(tracks, each);
  if (!first) return std::nullopt;

  Solution best = equations_at(tracks, each, *first);
  for (int i = 0; i < kReweightings; ++i) {
    for (std::size_t k = 0; k < tracks.size(); ++k) {
      reweight(tracks[k], each[k], best.y);
      each[k] = equations(tracks[k]);
    }
    const Solution here = equations_at(tracks, each, best.y);
    const auto better = towards(tracks, each, here, solve_symmetric(here.S, here.s));
    if (!better) break;
    best = equations_at(tracks, each, *better);
  }
  LinearMotion result{.cost = best.cost};
  result.free_gravity = best.y.tail<3>().norm();
  const Matrix6d P = inverse_symmetric(best.S);
  const Eigen::Vector3d down = best.y.tail<3>().normalized();
  result.free_gravity_sigma =
      std::sqrt(std::max(0.0, down.dot(P.bottomRightCorner<3, 3>() * down)));
  Unknown y = best.y;
  y.tail<3>() = gravity * down;
  const Unknown held = on_sphere(best.S, best.s, best.y, gravity);
  if (truncated_cost(tracks, each, held) < truncated_cost(tracks, each, y)) y = held;
  if (!y.allFinite() || !std::isfinite(result.free_gravity_sigma)) return std::nullopt;
  result.v = y.head<3>();
  result.gravity = y.tail<3>();
  return result;
}

}  // namespace chasles
