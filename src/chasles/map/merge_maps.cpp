#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

#include <chasles/error.hpp>
#include <chasles/eval/chi2.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/map/merge_maps.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Match = PlaceInMap::Match;

// The place is found from what a camera saw: points whose cameras were within this part of the
// distance from each other.
constexpr double kOneView = 0.4;
constexpr std::size_t kLeastPoints = 7;
// Places that are the same but for the drift of the maps [m, rad].
constexpr double kSamePosition = 1, kSameHeading = 0.1;
// Landmarks of both at the place itself, and in all.
constexpr int kLeastAtPlace = 6, kLeastMatches = 10;
// As for the landmarks of a run (docs/recognition.md): bits that differ, and pixels by which the
// point that is found again is another one.
constexpr int kSimilar = 50;
constexpr double kOtherPoint = 1.5;
constexpr double kProbability = 0.99, kTogether = 0.999;
// Sigmas of the place [rad, m]: they say nothing beside the matches.
constexpr double kHeadingSigma = 0.3, kPositionSigma = 5;

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

// Both maps in the frame of a. Their errors by independent ones y of covariance I: those that each
// map shares, and those of the place; and the points' own errors.
class Both {
 public:
  /// The place's heading turns about the mean of what both have.
  Both(const LandmarkMap& a, const LandmarkMap& b, SE3 a_T_b, std::span<const Match> matches)
      : a_(a), b_(b), a_T_b_(std::move(a_T_b)) {
    for (const Match& match : matches) {
      pivot_ += p_b(match.seen) / static_cast<double>(matches.size());
    }
  }

  struct Difference {
    Vector3d d;     // of b's point from a's
    MatrixXd H;     // by y
    Matrix3d V;     // covariance of what is their own
    Matrix3d gain;  // of a's own error
  };
  Difference difference(const Match& match) const {
    Difference result;
    result.d = p_b(match.seen) - a_.points[static_cast<std::size_t>(match.point)].p_map;
    result.H = rows_b(match.seen) - rows_a(match.point);
    const Matrix3d& D_a = a_.covariance.own()[static_cast<std::size_t>(match.point)];
    result.V = D_a + own_b(match.seen) + other_point(match);
    result.gain = D_a * result.V.inverse();
    return result;
  }

  struct Posterior {
    VectorXd mean;  // of y
    MatrixXd root;  // of its covariance
    double nis = 0;
  };
  Posterior solve(std::span<const Match> matches) const {
    MatrixXd information = MatrixXd::Identity(size(), size());
    VectorXd b = VectorXd::Zero(size());
    double squares = 0;
    for (const Match& match : matches) {
      const Difference one = difference(match);
      const Eigen::LLT<Matrix3d> V(one.V);
      const MatrixXd whitened = V.matrixL().solve(one.H);
      const Vector3d d = V.matrixL().solve(one.d);
      information += whitened.transpose() * whitened;
      b -= whitened.transpose() * d;
      squares += d.squaredNorm();
    }
    const Eigen::LLT<MatrixXd> llt(information);
    Posterior result;
    result.mean = llt.solve(b);
    result.root = llt.matrixU().solve(MatrixXd::Identity(size(), size()));
    result.nis = squares - b.dot(result.mean);
    return result;
  }

  // Moves the place to where the matches say it is.
  void relinearise(std::span<const Match> matches) {
    constexpr int kSteps = 3;
    for (int step = 0; step < kSteps; ++step) {
      const Eigen::Vector4d by = solve(matches).mean.tail<4>();
      const Matrix3d turn = so3::exp({0, 0, kHeadingSigma * by(0)});
      a_T_b_.R = turn * a_T_b_.R;
      a_T_b_.p = pivot_ + turn * (a_T_b_.p - pivot_) + kPositionSigma * by.tail<3>();
    }
  }

  // Squared innovation of a difference: given others, or given all of which it is one.
  double square(const Match& match, const Posterior& given, bool is_one) const {
    const Difference one = difference(match);
    const MatrixXd by_root = one.H * given.root;
    const Matrix3d P = by_root * by_root.transpose();
    const Matrix3d S = is_one ? Matrix3d(one.V - P) : Matrix3d(one.V + P);
    const Vector3d r = one.d + one.H * given.mean;
    return r.dot(S.ldlt().solve(r));
  }

  MergedMaps merged(std::span<const Match> matches) const {
    const Posterior posterior = solve(matches);
    MergedMaps result{.map = {},
                      .a_T_b = a_T_b_,
                      .matches = static_cast<int>(matches.size()),
                      .nis = posterior.nis};
    const auto n_a = static_cast<Index>(a_.points.size());
    std::vector<const Match*> of_a(a_.points.size());
    std::vector<bool> taken(b_.points.size());
    for (const Match& match : matches) {
      of_a[static_cast<std::size_t>(match.point)] = &match;
      taken[static_cast<std::size_t>(match.seen)] = true;
    }
    LandmarkMap& map = result.map;
    map.sessions = a_.sessions;
    map.sessions.insert(map.sessions.end(), b_.sessions.begin(), b_.sessions.end());
    std::vector<Matrix3d> own;
    MatrixXd shared(3 * (n_a + static_cast<Index>(b_.points.size())), size());
    const auto add = [&](MapPoint point, const MatrixXd& rows, const Matrix3d& D) {
      shared.middleRows<3>(3 * static_cast<Index>(map.points.size())) = rows;
      point.p_map += rows * posterior.mean;
      own.push_back((D + D.transpose()) / 2);
      map.points.push_back(std::move(point));
    };
    for (std::size_t i = 0; i < a_.points.size(); ++i) {
      const auto index = static_cast<int>(i);
      MapPoint point = a_.points[i];
      const Matrix3d& D = a_.covariance.own()[i];
      if (of_a[i] == nullptr) {
        add(std::move(point), rows_a(index), D);
        continue;
      }
      const Difference one = difference(*of_a[i]);
      const MapPoint& other = b_.points[static_cast<std::size_t>(of_a[i]->seen)];
      point.p_map += one.gain * one.d;
      point.observations += other.observations;
      const Appearance in_a = other.appearance.turned(a_T_b_.R);
      for (const PatchView& view : in_a.views()) point.appearance.add(view);
      add(std::move(point), rows_a(index) + one.gain * one.H, D - one.gain * D);
    }
    for (std::size_t i = 0; i < b_.points.size(); ++i) {
      if (taken[i]) continue;
      const auto index = static_cast<int>(i);
      MapPoint point = b_.points[i];
      point.p_map = p_b(index);
      point.session += static_cast<int>(a_.sessions.size());
      point.appearance = point.appearance.turned(a_T_b_.R);
      if (point.appearance.empty()) continue;
      add(std::move(point), rows_b(index), own_b(index));
    }
    shared.conservativeResize(3 * static_cast<Index>(own.size()), Eigen::NoChange);
    map.covariance =
        JointCovariance(std::move(own), dense::product(shared, posterior.root)).reduced({});
    return result;
  }

  // Where a point may lie: its mean, and the largest variance by shared and own errors.
  struct Whereabouts {
    Vector3d p;
    double variance = 0;
    Appearance appearance;
  };
  std::vector<Whereabouts> whereabouts(bool of_a, const Posterior& given) const {
    const LandmarkMap& map = of_a ? a_ : b_;
    std::vector<Whereabouts> result;
    for (int i = 0; i < static_cast<int>(map.points.size()); ++i) {
      const MapPoint& point = map.points[static_cast<std::size_t>(i)];
      const MatrixXd rows = of_a ? rows_a(i) : rows_b(i);
      const Vector3d p = of_a ? point.p_map : p_b(i);
      result.push_back({.p = p + rows * given.mean,
                        .variance = (rows * given.root).squaredNorm() +
                                    map.covariance.own()[static_cast<std::size_t>(i)].trace(),
                        .appearance = of_a ? point.appearance : point.appearance.turned(a_T_b_.R)});
    }
    return result;
  }

 private:
  Index r_a() const { return a_.covariance.rank(); }
  Index r_b() const { return b_.covariance.rank(); }
  Index size() const { return r_a() + r_b() + 4; }
  Vector3d p_b(int point) const {
    return a_T_b_ * b_.points[static_cast<std::size_t>(point)].p_map;
  }
  Matrix3d own_b(int point) const {
    return a_T_b_.R * b_.covariance.own()[static_cast<std::size_t>(point)] * a_T_b_.R.transpose();
  }
  MatrixXd rows_a(int point) const {
    MatrixXd rows = MatrixXd::Zero(3, size());
    rows.leftCols(r_a()) = a_.covariance.shared().middleRows<3>(3 * static_cast<Index>(point));
    return rows;
  }
  MatrixXd rows_b(int point) const {
    MatrixXd rows = MatrixXd::Zero(3, size());
    rows.middleCols(r_a(), r_b()) =
        a_T_b_.R * b_.covariance.shared().middleRows<3>(3 * static_cast<Index>(point));
    rows.col(r_a() + r_b()) = kHeadingSigma * Vector3d::UnitZ().cross(p_b(point) - pivot_);
    rows.rightCols<3>() = kPositionSigma * Matrix3d::Identity();
    return rows;
  }
  Matrix3d other_point(const Match& match) const {
    const MapPoint& point = a_.points[static_cast<std::size_t>(match.point)];
    if (point.appearance.empty()) return Matrix3d::Zero();
    const double pixel = 1e-3 * std::exp2(point.appearance.views().front().level / 2.0);  // [m]
    return kOtherPoint * kOtherPoint * pixel * pixel * Matrix3d::Identity();
  }

  const LandmarkMap& a_;
  const LandmarkMap& b_;
  SE3 a_T_b_;
  Vector3d pivot_ = Vector3d::Zero();
};

// Worst first, until all agree with the others.
void drop_contradictions(const Both& both, std::vector<Match>& matches) {
  const double most = chi2_quantile(kProbability, 3);
  while (!matches.empty()) {
    const Both::Posterior all = both.solve(matches);
    std::vector<double> squares;
    for (const Match& match : matches) squares.push_back(both.square(match, all, true));
    const auto worst = std::ranges::max_element(squares);
    if (*worst <= most) return;
    matches.erase(matches.begin() + (worst - squares.begin()));
  }
}

bool look_alike(const Appearance& a, const Appearance& b) {
  return std::ranges::any_of(b.views(), [&](const PatchView& view) {
    return a.distance(view).value_or(kSimilar + 1) <= kSimilar;
  });
}

// Further landmarks that look the same where they should be.
void add_matches(const Both& both, std::vector<Match>& matches) {
  constexpr double kFar = 4;  // sigmas
  const double most = chi2_quantile(kProbability, 3);
  std::set<int> of_a, of_b;
  for (const Match& match : matches) {
    of_a.insert(match.point);
    of_b.insert(match.seen);
  }
  const Both::Posterior given = both.solve(matches);
  const std::vector<Both::Whereabouts> a = both.whereabouts(true, given),
                                       b = both.whereabouts(false, given);
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

void check_sessions(const LandmarkMap& a, const LandmarkMap& b) {
  for (const MapSession& x : a.sessions) {
    for (const MapSession& y : b.sessions) {
      if (x.name == y.name && x.begin <= y.end && y.begin <= x.end) {
        throw InputError(
            fmt::format("both maps have a session of the recording {}: merging them would count it "
                        "twice; extend one of them "
                        "by a run in it instead (chasles run --map MAP --extend)",
                        x.name));
      }
    }
  }
}

}  // namespace

MergedMaps merge_maps(const LandmarkMap& a, const LandmarkMap& b) {
  check_sessions(a, b);
  const std::optional<Proposed> place = common_place(a, b);
  std::vector<Match> matches = place ? place->matches : std::vector<Match>{};
  if (static_cast<int>(matches.size()) >= kLeastAtPlace) {
    Both both(a, b, place->a_T_b, matches);
    both.relinearise(matches);
    drop_contradictions(both, matches);
    if (static_cast<int>(matches.size()) >= kLeastAtPlace) {
      both.relinearise(matches);
      add_matches(both, matches);
      both.relinearise(matches);
      drop_contradictions(both, matches);
      const auto numbers = 3 * static_cast<int>(matches.size());
      const bool agree = both.solve(matches).nis < chi2_quantile(kTogether, numbers);
      if (static_cast<int>(matches.size()) >= kLeastMatches && agree) return both.merged(matches);
    }
  }
  throw InputError(
      fmt::format("the maps have no place in common: found {} landmarks that look alike and fit "
                  "together, expected {}",
                  matches.size(), kLeastMatches));
}

MergedMaps merge_maps(const LandmarkMap& a, const LandmarkMap& b, SE3 a_T_b,
                      std::span<const Match> matches) {
  return Both(a, b, std::move(a_T_b), matches).merged(matches);
}

}  // namespace chasles
