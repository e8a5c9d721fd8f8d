#include <algorithm>
#include <set>
#include <utility>

#include <chasles/eval/chi2.hpp>
#include <chasles/loop/map_matches.hpp>

namespace chasles {
namespace {

using Match = MapFusion::Match;

constexpr double kProbability = 0.99, kTogether = 0.999;

bool are_similar(const Appearance& a, const Appearance& b) {
  return std::ranges::any_of(b.views(), [&](const PatchView& view) {
    return a.distance(view).value_or(kSimilarBits + 1) <= kSimilarBits;
  });
}

}  // namespace

double most_nis(int matches) { return chi2_quantile(kTogether, 3 * matches); }

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
          of_a.contains(static_cast<int>(i)) || !are_similar(a[i].appearance, b[j].appearance)) {
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

}  // namespace chasles
