#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/base/median.hpp>
#include <chasles/eval/chi2.hpp>
#include <chasles/loop/map_extensions.hpp>
#include <chasles/loop/map_matches.hpp>

namespace chasles {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// How well the landmarks of base determine each of the shared errors: U^T D^-1 U over them.
MatrixXd information_on_shared(const LandmarkMap& map, const std::vector<int>& of_base) {
  constexpr double kLeast = 1e-12, kSmall = 1e-6;  // [m^2], and of the variance
  MatrixXd information = MatrixXd::Zero(map.covariance.rank(), map.covariance.rank());
  for (std::size_t i = 0; i < of_base.size(); ++i) {
    if (of_base[i] < 0) continue;
    const Matrix3d& D = map.covariance.own()[i];
    const double more = std::max(kLeast, kSmall * D.trace());
    const Eigen::LLT<Matrix3d> root(D + more * Matrix3d::Identity());
    const MatrixXd U = map.covariance.shared().middleRows<3>(3 * static_cast<Index>(i));
    const MatrixXd whitened = root.matrixL().solve(U);
    information += whitened.transpose() * whitened;
  }
  return information;
}

// With the covariance of base's landmarks n-fold, and what is known of the others given them as it
// is. In the directions in which the landmarks of base determine the shared errors by a, these
// others would have 1 + (n - 1) a / (1 + a) times the square of their shared part; the shared part
// of base's landmarks is then as much larger as the covariance of both needs. That is n-fold where
// it counts, and never less.
LandmarkMap weighted(const LandmarkMap& extension, const std::vector<int>& of_base, double n) {
  LandmarkMap map = extension;
  std::vector<Matrix3d> own = map.covariance.own();
  MatrixXd shared = map.covariance.shared();
  if (shared.cols() > 0) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(information_on_shared(map, of_base));
    const VectorXd a = solver.eigenvalues().cwiseMax(0);
    const VectorXd others = (1 + (n - 1) * a.array() / (1 + a.array())).sqrt();
    const MatrixXd turned = shared * solver.eigenvectors();
    for (std::size_t i = 0; i < own.size(); ++i) {
      const VectorXd factors = of_base[i] < 0 ? others : VectorXd(n * others.cwiseInverse());
      const Index at = 3 * static_cast<Index>(i);
      shared.middleRows<3>(at) = turned.middleRows<3>(at) * factors.asDiagonal();
    }
  }
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (of_base[i] >= 0) own[i] *= n;
  }
  map.covariance = JointCovariance(std::move(own), std::move(shared));
  return map;
}

LandmarkMap weighted(const LandmarkMap& base, const MapPart& extension, double n) {
  const std::vector<int> of_base = points_of(base, extension.map);
  const auto found = static_cast<std::size_t>(
      std::ranges::count_if(of_base, [](int index) { return index >= 0; }));
  if (found > 2 && 2 * found >= base.points.size()) return weighted(extension.map, of_base, n);
  throw InputError(fmt::format(
      "{}: found {} of the {} landmarks of the map that its sessions say it began in, expected "
      "most of them; leave it out",
      extension.name, found, base.points.size()));
}

// Landmarks of base that both have, a point of b each.
std::vector<MapFusion::Match> common_points(std::size_t base, const std::vector<int>& of_a,
                                            const std::vector<int>& of_b) {
  std::vector<int> in_a(base, -1);
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    if (of_a[i] >= 0) in_a[static_cast<std::size_t>(of_a[i])] = static_cast<int>(i);
  }
  std::vector<MapFusion::Match> matches;
  for (std::size_t j = 0; j < of_b.size(); ++j) {
    const int point = of_b[j] < 0 ? -1 : in_a[static_cast<std::size_t>(of_b[j])];
    if (point >= 0) matches.push_back({.seen = static_cast<int>(j), .point = point});
  }
  return matches;
}

// The sessions of base are those of both.
void count_sessions_once(std::size_t of_base, std::size_t of_a, LandmarkMap& map) {
  const auto first = map.sessions.begin() + static_cast<std::ptrdiff_t>(of_a);
  map.sessions.erase(first, first + static_cast<std::ptrdiff_t>(of_base));
  for (MapPoint& point : map.points) {
    const int of_b = point.session - static_cast<int>(of_a);
    if (of_b < 0) continue;
    const bool common = of_b < static_cast<int>(of_base);
    point.session = common ? of_b : point.session - static_cast<int>(of_base);
  }
}

LandmarkMap scaled(LandmarkMap map, double variance) {
  std::vector<Matrix3d> own = map.covariance.own();
  for (Matrix3d& D : own) D *= variance;
  map.covariance = JointCovariance(std::move(own), std::sqrt(variance) * map.covariance.shared());
  return map;
}

LandmarkMap without(const LandmarkMap& map, const std::vector<bool>& left_out) {
  LandmarkMap result{.sessions = map.sessions, .points = {}, .covariance = {}};
  std::vector<Matrix3d> own;
  MatrixXd shared(map.covariance.shared().rows(), map.covariance.rank());
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    if (left_out[i]) continue;
    shared.middleRows<3>(3 * static_cast<Index>(own.size())) =
        map.covariance.shared().middleRows<3>(3 * static_cast<Index>(i));
    own.push_back(map.covariance.own()[i]);
    result.points.push_back(map.points[i]);
  }
  shared.conservativeResize(3 * static_cast<Index>(own.size()), Eigen::NoChange);
  result.covariance = JointCovariance(std::move(own), std::move(shared));
  return result;
}

// By how much the differences of single landmarks exceed their covariance.
double excess(const MapFusion& both, const std::vector<MapFusion::Match>& matches) {
  const MapFusion::Posterior all = both.solve(matches);
  std::vector<double> squares;
  for (const MapFusion::Match& match : matches) squares.push_back(both.square(match, all, true));
  return std::max(1.0, median(squares) / chi2_quantile(0.5, 3));
}

// Two maps as they agree: with larger covariances where their differences show these to be too
// small, and without the second one's landmarks of base that contradict all others.
struct Agreed {
  LandmarkMap a, b;
  double variance = 1;  // what was applied to both
};

Agreed agreed(const LandmarkMap& base, const LandmarkMap& a, const LandmarkMap& b,
              const std::string& name) {
  constexpr double kMostVariance = 25;
  const std::vector<MapFusion::Match> common =
      common_points(base.points.size(), points_of(base, a), points_of(base, b));
  const double of_single = excess(MapFusion(a, b, common), common);
  Agreed result{.a = scaled(a, of_single), .b = scaled(b, of_single), .variance = of_single};
  std::vector<MapFusion::Match> kept = common;
  const MapFusion both(result.a, result.b, common);
  drop_contradictions(both, kept);
  const double count = 3 * std::max(1.0, static_cast<double>(kept.size()));
  const double of_all = std::max(1.0, both.solve(kept).nis / count);
  result.variance *= of_all;
  if (2 * kept.size() < common.size() || result.variance > kMostVariance) {
    throw InputError(fmt::format(
        "{}: contradicts the other runs in the same map: of {} landmarks that both have, {} agree, "
        "and their differences are {:.1f} times what their covariances allow, expected at most {}; "
        "leave it out",
        name, common.size(), kept.size(), std::sqrt(result.variance), std::sqrt(kMostVariance)));
  }
  std::vector<bool> left_out(b.points.size());
  for (const auto& match : common) left_out[static_cast<std::size_t>(match.seen)] = true;
  for (const auto& match : kept) left_out[static_cast<std::size_t>(match.seen)] = false;
  result.a = scaled(std::move(result.a), of_all);
  result.b = without(scaled(std::move(result.b), of_all), left_out);
  return result;
}

// Two extensions, or what was joined of them already and one more, both weighted.
LandmarkMap join_weighted(const LandmarkMap& base, const LandmarkMap& first,
                          const LandmarkMap& second, const std::string& name) {
  const auto [a, b, variance] = agreed(base, first, second, name);
  const std::vector<int> of_a = points_of(base, a);
  const std::vector<MapFusion::Match> common =
      common_points(base.points.size(), of_a, points_of(base, b));
  const MapFusion both(a, b, common);
  std::vector<MapFusion::Match> matches = common;
  add_matches(both, matches);
  LandmarkMap map = both.joined(matches).map;
  for (const MapFusion::Match& match : common) {
    const auto point = static_cast<std::size_t>(match.point);
    map.points[point].observations -=
        base.points[static_cast<std::size_t>(of_a[point])].observations;
  }
  count_sessions_once(base.sessions.size(), a.sessions.size(), map);
  return map;
}

bool is_same_session(const MapSession& a, const MapSession& b) {
  return a.name == b.name && a.begin == b.begin && a.end == b.end;
}

}  // namespace

bool extends(const LandmarkMap& map, const LandmarkMap& base) {
  return map.sessions.size() > base.sessions.size() &&
         std::ranges::equal(base.sessions, std::span(map.sessions).first(base.sessions.size()),
                            is_same_session);
}

std::vector<int> points_of(const LandmarkMap& base, const LandmarkMap& map) {
  std::map<std::array<Descriptor, PatchView::kLevels>, int> known;
  for (std::size_t i = 0; i < base.points.size(); ++i) {
    for (const PatchView& view : base.points[i].appearance.views()) {
      known.emplace(view.descriptors, static_cast<int>(i));
    }
  }
  std::vector<bool> taken(base.points.size());
  std::vector<int> indices;
  for (const MapPoint& point : map.points) {
    int& index = indices.emplace_back(-1);
    if (point.session >= static_cast<int>(base.sessions.size())) continue;
    for (const PatchView& view : point.appearance.views()) {
      const auto found = known.find(view.descriptors);
      if (found == known.end() || taken[static_cast<std::size_t>(found->second)]) continue;
      index = found->second;
      taken[static_cast<std::size_t>(index)] = true;
      break;
    }
  }
  return indices;
}

LandmarkMap joined_extensions(const LandmarkMap& base, std::span<const MapPart> extensions) {
  if (extensions.size() == 1) return extensions.front().map;
  const auto n = static_cast<double>(extensions.size());
  LandmarkMap all = weighted(base, extensions.front(), n);
  for (const MapPart& extension : extensions.subspan(1)) {
    all = join_weighted(base, all, weighted(base, extension, n), extension.name);
  }
  return all;
}

}  // namespace chasles
