#include <algorithm>
#include <chrono>
#include <numeric>
#include <utility>

#include <Eigen/Cholesky>

#include <chasles/filter/dense.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/loop/map_placer.hpp>

namespace chasles {
namespace {

// Searches in a row without compatible landmarks after which a proposed place is given up.
constexpr int kMostFailures = 2;
constexpr int kLeastSeen = 7, kLeastCommon = 3;
// Landmarks that left the state since help to find the place.
constexpr Time kRecently = std::chrono::seconds(4);

}  // namespace

std::optional<PlaceInMap> MapPlacer::search(const Surroundings& here) {
  if (here.observed.size() < kLeastSeen) return std::nullopt;
  ++counts_.searches;
  const State& x = here.filter.state();
  std::vector<PlacePoint> points;
  for (const ObservedLandmark& s : here.observed) {
    const Eigen::Vector3d p_world = x.p_world(x.landmarks[static_cast<std::size_t>(s.index)]);
    points.push_back(
        {.p_world = x.nav_T_world ? *x.nav_T_world * p_world : p_world, .view = s.view});
  }
  for (const auto& [id, past] : here.past) {
    if (here.now - past.left > kRecently) continue;
    points.push_back({.p_world = past.p_nav, .view = past.appearance.views().front()});
  }
  return find_place(points, here.p_nav(), *map_);
}

void MapPlacer::propose(const Surroundings& here) {
  const auto place = search(here);
  if (!place) return;
  ++counts_.proposed;
  place_ = MapPlace{.world_T_map = place->world_T_map, .pivot = here.p_nav()};
  put_points_in_place();
}

void MapPlacer::propose_nav() {
  place_ = MapPlace{.world_T_map = {}, .heading_sigma = 0, .position_sigma = 0};
  put_points_in_place();
}

bool MapPlacer::finds_again(const Surroundings& here, const LoopInnovations& innovations,
                            const std::vector<int>& accepted,
                            const std::vector<LoopCandidate>& candidates) {
  const auto place = search(here);
  if (!place) return false;
  return kLeastCommon <= std::ranges::count_if(accepted, [&](int i) {
           const ProposedMatch& match = innovations.matches[static_cast<std::size_t>(i)];
           const int point = candidates[static_cast<std::size_t>(match.landmark)].past->number;
           return std::ranges::any_of(place->matches, [&](const PlaceInMap::Match& m) {
             return m.seen == match.observation && m.point == point;
           });
         });
}

void MapPlacer::note_failure() {
  failures_ = compatible_.empty() ? failures_ + 1 : 0;
  if (failures_ >= kMostFailures) reject();
}

void MapPlacer::reject() {
  const PlaceCounts counts = counts_;
  *this = MapPlacer(map_);
  counts_ = counts;
  ++counts_.rejected;
}

void MapPlacer::put_points_in_place() {
  const SE3& nav_T_map = place_->world_T_map;
  for (std::size_t i = 0; i < map_->points.size(); ++i) {
    const MapPoint& point = map_->points[i];
    points_[kFirstMapId + static_cast<LandmarkId>(i)] = {
        .number = static_cast<int>(i),
        .p_nav = nav_T_map * point.p_map,
        .appearance = point.appearance.turned(nav_T_map.R)};
  }
}

KnownLandmarks MapPlacer::known_points(const Ekf& filter,
                                       const std::vector<LoopCandidate>& candidates) const {
  using Eigen::Index;
  using Eigen::MatrixXd;
  std::vector<int> points;
  for (const LoopCandidate& c : candidates) points.push_back(c.past->number);
  const PriorMap known = placed(*map_, points, *place_);
  const auto k = 3 * static_cast<Index>(points.size());
  const MatrixXd A = known.shared.bottomRows(k), A_transposed = A.transpose();
  MatrixXd P = dense::product(A, A_transposed);
  for (Index i = 0; i < k; i += 3) {
    P.block<3, 3>(i, i) += known.own[static_cast<std::size_t>(i / 3)];
  }
  return {.landmarks = known.landmarks,
          .C = MatrixXd::Zero(k, filter.covariance().rows()),
          .P = std::move(P),
          .by_place = A.rightCols<4>()};
}

// The whole map is linearised at its place: an error of the heading of 0.03 rad would make it 5 cm
// larger in 100 m. So the accepted matches determine the place first. They count when the landmarks
// are observed; the place is then no more than where these are linearised.
void MapPlacer::refine(const Surroundings& here, double pixel_sigma,
                       const LoopInnovations& innovations, const std::vector<int>& accepted,
                       const std::vector<LoopCandidate>& candidates) {
  constexpr int kRefinements = 3;
  std::vector<LoopCandidate> matched;
  for (const int i : accepted) {
    const ProposedMatch& match = innovations.matches[static_cast<std::size_t>(i)];
    matched.push_back(candidates[static_cast<std::size_t>(match.landmark)]);
    matched.back().like = {{0, match.observation}};
  }
  std::ranges::sort(matched, {}, [](const LoopCandidate& c) { return c.past->number; });
  for (int step = 0; step < kRefinements; ++step) {
    LoopInnovations now = loop_innovations(here.cameras.front(), here.filter, matched,
                                           known_points(here.filter, matched), here.observed);
    now.S.diagonal().array() += returned_variance(pixel_sigma);
    const Eigen::Vector4d error = now.by_place.transpose() * now.S.ldlt().solve(now.r);
    MapPlace& place = *place_;
    const Eigen::Matrix3d turn = so3::exp(Eigen::Vector3d(0, 0, place.heading_sigma * error[0]));
    SE3& nav_T_map = place.world_T_map;
    nav_T_map.R = turn * nav_T_map.R;
    nav_T_map.p =
        place.pivot + turn * (nav_T_map.p - place.pivot) + place.position_sigma * error.tail<3>();
  }
  put_points_in_place();
}

PriorMap MapPlacer::placed_map() const {
  std::vector<int> all(map_->points.size());
  std::iota(all.begin(), all.end(), 0);
  return placed(*map_, all, *place_);
}

std::shared_ptr<const LandmarkMap> MapPlacer::finish(Time time) {
  auto map = std::move(map_);
  const PlaceCounts counts = counts_;
  *this = MapPlacer();
  counts_ = counts;
  counts_.placed = time;
  return map;
}

}  // namespace chasles
