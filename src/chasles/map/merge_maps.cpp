#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include <chasles/error.hpp>
#include <chasles/eval/chi2.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/map/map_fusion.hpp>

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
constexpr double kProbability = 0.99, kTogether = 0.999;

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

// Worst first, until all agree with the others.
void drop_contradictions(const MapFusion& both, std::vector<Match>& matches) {
  const double most = chi2_quantile(kProbability, 3);
  while (!matches.empty()) {
    const MapFusion::Posterior all = both.solve(matches);
    std::vector<double> squares;
    for (const Match& match : matches) squares.push_back(both.square(match, all, true));
    const auto worst = std::ranges::max_element(squares);
    if (*worst <= most) return;
    matches.erase(matches.begin() + (worst - squares.begin()));
  }
}

bool look_alike(const Appearance& a, const Appearance& b) {
  return std::ranges::any_of(b.views(), [&](const PatchView& view) {
    return a.distance(view).value_or(kSimilarBits + 1) <= kSimilarBits;
  });
}

// Further landmarks that look the same where they should be.
void add_matches(const MapFusion& both, std::vector<Match>& matches) {
  constexpr double kFar = 4;  // sigmas
  const double most = chi2_quantile(kProbability, 3);
  std::set<int> of_a, of_b;
  for (const Match& match : matches) {
    of_a.insert(match.point);
    of_b.insert(match.seen);
  }
  const MapFusion::Posterior given = both.solve(matches);
  const std::vector<MapFusion::Whereabouts> a = both.points_of_a(given),
                                            b = both.points_of_b(given);
  std::vector<std::pair<double, Match>> more;
  for (std::size_t j = 0; j < b.size(); ++j) {
    if (of_b.contains(static_cast<int>(j))) continue;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double variance = 2 * (a[i].variance + b[j].variance);  // at most
      if ((a[i].p - b[j].p).squaredNorm() > kFar * kFar * variance ||
          of_a.contains(static_cast<int>(i)) || !look_alike(a[i].appearance, b[j].appearance)) {
        continue;
      }
      const Match match{.seen = static_cast<int>(j), .point = static_cast<int>(i)};
      const double square = both.square(match, given, false);
      if (square <= most) more.emplace_back(square, match);
    }
  }
  std::ranges::stable_sort(more, {}, [](const auto& one) { return one.first; });
  for (const auto& [square, match] : more) {
    if (of_a.contains(match.point) || of_b.contains(match.seen)) continue;
    of_a.insert(match.point);
    of_b.insert(match.seen);
    matches.push_back(match);
  }
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
      const double nis = both.solve(matches).nis, most = chi2_quantile(kTogether, 3 * count);
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

// A total order of maps that may be merged: no two have a session that begins alike.
bool before(const MapPart& x, const MapPart& y) {
  const auto key = [](const MapSession& session) { return std::tie(session.begin, session.name); };
  return std::ranges::lexicographical_compare(
      x.map.sessions, y.map.sessions,
      [&](const MapSession& a, const MapSession& b) { return key(a) < key(b); });
}

// Two runs never leave the same numbers to the last bit.
bool same(const LandmarkMap& x, const LandmarkMap& y) {
  const auto same_session = [](const MapSession& a, const MapSession& b) {
    return a.name == b.name && a.begin == b.begin && a.end == b.end;
  };
  const auto same_point = [](const MapPoint& a, const MapPoint& b) {
    return a.p_map == b.p_map && a.session == b.session && a.observations == b.observations;
  };
  return std::ranges::equal(x.sessions, y.sessions, same_session) &&
         std::ranges::equal(x.points, y.points, same_point) &&
         x.covariance.own() == y.covariance.own() && x.covariance.rank() == y.covariance.rank() &&
         x.covariance.shared() == y.covariance.shared();
}

void check_sessions(const MapPart& a, const MapPart& b) {
  for (const MapSession& x : a.map.sessions) {
    for (const MapSession& y : b.map.sessions) {
      if (x.name == y.name && x.begin <= y.end && y.begin <= x.end) {
        throw InputError(fmt::format(
            "{} and {}: different maps with a session of the recording {}: merging them would "
            "count it twice; leave one of them out, or extend one by a run in it instead (chasles "
            "run --map MAP --extend)",
            a.name, b.name, x.name));
      }
    }
  }
}

// In their order, each once.
void arrange(std::vector<MapPart>& parts) {
  std::vector<MapPart> once;
  for (MapPart& part : parts) {
    const auto known = [&](const MapPart& other) { return same(part.map, other.map); };
    if (std::ranges::none_of(once, known)) once.push_back(std::move(part));
  }
  for (std::size_t i = 0; i < once.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) check_sessions(once[k], once[i]);
  }
  std::ranges::sort(once, before);
  parts = std::move(once);
}

std::string names(std::span<const MapPart* const> parts) {
  std::string all;
  for (const MapPart* part : parts) all += (all.empty() ? "" : ", ") + part->name;
  return all;
}

}  // namespace

MergedMaps merge_maps(std::vector<MapPart> parts) {
  if (parts.empty()) throw UsageError("merging needs a map: found none");
  arrange(parts);
  MergedMaps result{.map = parts.front().map, .parts = {}, .joined = {}};
  std::vector<const MapPart*> together{&parts.front()}, waiting;
  for (std::size_t i = 1; i < parts.size(); ++i) waiting.push_back(&parts[i]);
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
  if (parts.size() > 1) {
    for (MapPart& part : parts) result.parts.push_back(std::move(part.map));
  }
  return result;
}

JoinedMaps join_maps(const LandmarkMap& a, const LandmarkMap& b, const SE3& a_T_b,
                     std::span<const Match> matches) {
  return MapFusion(a, b, a_T_b, matches).joined(matches);
}

}  // namespace chasles
