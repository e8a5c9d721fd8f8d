#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/loop/map_family.hpp>
#include <chasles/loop/map_fusion.hpp>
#include <chasles/loop/map_matches.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;
using Match = PlaceInMap::Match;

// The place is found from what a camera saw: points whose cameras were within this part of the
// distance from each other.
constexpr double kOneView = 0.4;
constexpr std::size_t kLeastPoints = 7;
// Places that are the same but for the drift of the maps [m, rad].
constexpr double kSamePosition = 1, kSameHeading = 0.1;
// Landmarks of both at the place itself, and in all.
constexpr int kLeastAtPlace = 6, kLeastMatches = 10;

// A place of map b in map a.
struct Proposed {
  SE3 a_T_b;
  Vector3d p_b;  // where it was found
  std::vector<Match> matches;
};

Vector3d camera_of(const MapPoint& point, const PatchView& view) {
  return point.p_map + view.distance() * view.from.cast<double>();
}

std::vector<Proposed> proposed_places(const LandmarkMap& a, const LandmarkMap& b) {
  std::vector<Proposed> proposed;
  std::set<std::pair<std::size_t, std::size_t>> done;  // views of b
  for (std::size_t i = 0; i < b.points.size(); ++i) {
    const auto& views = b.points[i].appearance.views();
    for (std::size_t v = 0; v < views.size(); ++v) {
      if (done.contains({i, v})) continue;
      const Vector3d centre = camera_of(b.points[i], views[v]);
      const double reach = kOneView * views[v].distance();
      std::vector<PlacePoint> seen;
      std::vector<int> points;
      for (std::size_t k = 0; k < b.points.size(); ++k) {
        const auto& others = b.points[k].appearance.views();
        for (std::size_t w = 0; w < others.size(); ++w) {
          if ((camera_of(b.points[k], others[w]) - centre).norm() > reach) continue;
          done.insert({k, w});
          seen.push_back({.p_world = b.points[k].p_map, .view = others[w]});
          points.push_back(static_cast<int>(k));
          break;
        }
      }
      if (seen.size() < kLeastPoints) continue;
      const auto place = find_place(seen, centre, a);
      if (!place) continue;
      Proposed one{.a_T_b = place->world_T_map.inverse(), .p_b = centre, .matches = {}};
      for (const Match& match : place->matches) {
        one.matches.push_back({points[static_cast<std::size_t>(match.seen)], match.point});
      }
      proposed.push_back(std::move(one));
    }
  }
  return proposed;
}

bool agree(const Proposed& x, const Proposed& y) {
  const double turn = so3::log(x.a_T_b.R * y.a_T_b.R.transpose()).norm();
  return turn < kSameHeading && (x.a_T_b * y.p_b - y.a_T_b * y.p_b).norm() < kSamePosition;
}

// The best supported place, with all matches that agree with it. What one map saw from somewhere is
// looked for in the other one, and the other way round.
std::optional<Proposed> common_place(const LandmarkMap& a, const LandmarkMap& b) {
  std::vector<Proposed> proposed = proposed_places(a, b);
  for (Proposed& one : proposed_places(b, a)) {
    const SE3 a_T_b = one.a_T_b.inverse();
    for (Match& match : one.matches) std::swap(match.seen, match.point);
    proposed.push_back({.a_T_b = a_T_b, .p_b = one.a_T_b * one.p_b, .matches = one.matches});
  }
  std::optional<Proposed> best;
  for (const Proposed& one : proposed) {
    Proposed all{.a_T_b = one.a_T_b, .p_b = one.p_b, .matches = {}};
    std::set<int> of_a, of_b;
    for (const Proposed& other : proposed) {
      if (!agree(one, other)) continue;
      for (const Match& match : other.matches) {
        if (of_a.contains(match.point) || of_b.contains(match.seen)) continue;
        of_a.insert(match.point);
        of_b.insert(match.seen);
        all.matches.push_back(match);
      }
    }
    if (!best || all.matches.size() > best->matches.size()) best = std::move(all);
  }
  return best;
}

// Two maps, where they have a place in common; else the number of landmarks that fit together.
struct Attempt {
  std::optional<JoinedMaps> joined;
  int matches = 0;
};

Attempt join(const LandmarkMap& a, const MapPart& b) {
  const std::optional<Proposed> place = common_place(a, b.map);
  std::vector<Match> matches = place ? place->matches : std::vector<Match>{};
  if (static_cast<int>(matches.size()) >= kLeastAtPlace) {
    MapFusion both(a, b.map, place->a_T_b, matches);
    both.relinearise(matches);
    drop_contradictions(both, matches);
    if (static_cast<int>(matches.size()) >= kLeastAtPlace) {
      both.relinearise(matches);
      add_matches(both, matches);
      both.relinearise(matches);
      drop_contradictions(both, matches);
      const auto count = static_cast<int>(matches.size());
      const double nis = both.solve(matches).nis, most = most_nis(count);
      if (count >= kLeastMatches && nis > most) {
        throw InputError(fmt::format(
            "{}: the map contradicts those before it: {} landmarks look alike and lie together, "
            "but the NIS of their differences is {:.0f}, expected at most {:.0f}; merge the others "
            "without it",
            b.name, count, nis, most));
      }
      if (count >= kLeastMatches) return {.joined = both.joined(matches), .matches = count};
    }
  }
  return {.joined = {}, .matches = static_cast<int>(matches.size())};
}

std::string names(std::span<const MapPart* const> parts) {
  std::string all;
  for (const MapPart* part : parts) all += (all.empty() ? "" : ", ") + part->name;
  return all;
}

}  // namespace

MergedMaps merge_maps(std::vector<MapPart> parts) {
  if (parts.empty()) throw UsageError("merging needs a map: found none");
  const MapFamilies families = map_families(std::move(parts));
  const std::vector<MapPart>& roots = families.joined;
  MergedMaps result{.map = roots.front().map, .parts = {}, .joined = {}};
  std::vector<const MapPart*> together{&roots.front()}, waiting;
  for (std::size_t i = 1; i < roots.size(); ++i) waiting.push_back(&roots[i]);
  while (!waiting.empty()) {
    Attempt attempt;
    int most = 0;
    auto next = waiting.begin();
    for (; next != waiting.end(); ++next) {
      attempt = join(result.map, **next);
      if (attempt.joined) break;
      most = std::max(most, attempt.matches);
    }
    if (next == waiting.end()) {
      throw InputError(fmt::format(
          "{}: no place in common with {}: found {} landmarks that look alike and fit together, "
          "expected {}; leave it out, or add a map of a walk that saw places of both",
          names(waiting), names(together), most, kLeastMatches));
    }
    result.joined.push_back({.sessions = (*next)->map.sessions,
                             .matches = attempt.joined->matches,
                             .nis = attempt.joined->nis});
    result.map = std::move(attempt.joined->map);
    together.push_back(*next);
    waiting.erase(next);
  }
  if (families.parts.size() > 1) result.parts = families.parts;
  return result;
}

JoinedMaps join_maps(const LandmarkMap& a, const LandmarkMap& b, const SE3& a_T_b,
                     std::span<const Match> matches) {
  return MapFusion(a, b, a_T_b, matches).joined(matches);
}

}  // namespace chasles
