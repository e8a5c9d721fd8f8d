#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include <chasles/target/corner_lattice.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

constexpr double kAngle = 0.26;             // [rad]: edges bend in lenses, and rings are coarse
constexpr double kLeastEdge = 4;            // [px]
constexpr std::size_t kMostCandidates = 8;  // nearest points in a direction

// An edge leads from one saddle point, by one of its directions, to a direction of another one.
struct EdgeEnd {
  int point = -1, edge = -1;
};
using EdgeEnds = std::vector<std::array<EdgeEnd, 4>>;

Vector2d direction(double angle) { return {std::cos(angle), std::sin(angle)}; }

// Whether it is dark on one side and light on the other all the way. The dark side of an edge of
// even number is clockwise of it.
bool is_edge(const GreyPlane& image, const SaddlePoint& from, const SaddlePoint& to, bool even) {
  const Vector2d way = to.pixel - from.pixel;
  const double length = way.norm();
  const Vector2d along = way / length, clockwise(-along.y(), along.x());
  const Vector2d aside = clockwise * (even ? 1 : -1) * std::clamp(0.05 * length, 1.25, 6.0);
  const double step = 0.35 * std::min(from.light - from.dark, to.light - to.dark);
  // Near its ends, all of a short edge is within the blur.
  const double begin = std::min(0.15, 2.5 / length);
  const int samples = std::clamp(static_cast<int>(length / 2), 4, 32);
  int wrong = 0;
  for (int k = 0; k < samples; ++k) {
    const Vector2d here = from.pixel + way * (begin + (1 - 2 * begin) * (k + 0.5) / samples);
    if (!image.contains(here + aside, 1) || !image.contains(here - aside, 1)) return false;
    const double rise = static_cast<double>(image.at(here - aside) - image.at(here + aside));
    if (rise < step && ++wrong > samples / 16) return false;
  }
  return true;
}

struct Candidate {
  double distance = 0;
  int point = 0, edge = 0;
};

// For each direction of a point, the points to which an edge may lead, the nearest first.
using Candidates = std::array<std::vector<Candidate>, 4>;
using Directions = std::array<Vector2d, 4>;

// The direction that is within kAngle of the way, or none. Of directions with the parity of
// `first`, which are opposite.
int direction_along(const Directions& directions, const Vector2d& way, double least,
                    std::size_t first) {
  for (std::size_t k = first; k < 4; k += 2) {
    if (directions[k].dot(way) > least) return static_cast<int>(k);
  }
  return -1;
}

Directions directions_of(const SaddlePoint& point) {
  Directions result;
  for (std::size_t k = 0; k < 4; ++k) result[k] = direction(point.edges[k]);
  return result;
}

// The directions by which an edge may lead from one point to another: one of each parity, so that
// the same side is dark.
struct EdgeDirections {
  int there = -1, back = -1;
};
std::optional<EdgeDirections> possible_edge(const Directions& from, const Directions& to,
                                            const Vector2d& way, double length) {
  const double least = std::cos(kAngle) * length;
  for (std::size_t parity = 0; parity < 2; ++parity) {
    const int there = direction_along(from, way, least, parity);
    if (there < 0) continue;
    const int back = direction_along(to, -way, least, 1 - parity);
    if (back >= 0) return EdgeDirections{there, back};
  }
  return std::nullopt;
}

// The points in squares of the image, to visit those around a place from near to far.
class PointBuckets {
 public:
  static constexpr double kSide = 32;  // [px]

  PointBuckets(const std::vector<SaddlePoint>& points, int width, int height)
      : columns_(bucket(width) + 1),
        rows_(bucket(height) + 1),
        buckets_(static_cast<std::size_t>(columns_) * rows_) {
    for (std::size_t p = 0; p < points.size(); ++p) {
      at(bucket(points[p].pixel.x()), bucket(points[p].pixel.y())).push_back(static_cast<int>(p));
    }
  }

  int most_rings() const { return std::max(columns_, rows_); }

  /// Calls visit(point) for the points of the squares that are `ring` squares away, where
  /// wanted(way to the middle of the square). What is nearer than ring * kSide is in this ring or
  /// an inner one.
  template <typename Wanted, typename Visit>
  void visit_ring(const Vector2d& from, int ring, const Wanted& wanted, const Visit& visit) const {
    const int x = bucket(from.x()), y = bucket(from.y());
    for (int row = std::max(0, y - ring); row <= std::min(rows_ - 1, y + ring); ++row) {
      const int step = ring == 0 || std::abs(row - y) == ring ? 1 : 2 * ring;
      for (int column = x - ring; column <= x + ring; column += step) {
        if (column < 0 || column >= columns_) continue;
        const auto& points = buckets_[static_cast<std::size_t>(row) * columns_ + column];
        if (points.empty()) continue;
        if (!wanted(kSide * Vector2d(column + 0.5, row + 0.5) - from)) continue;
        for (const int point : points) visit(point);
      }
    }
  }

 private:
  static int bucket(double pixel) { return std::max(0, static_cast<int>(pixel / kSide)); }
  std::vector<int>& at(int column, int row) {
    return buckets_[static_cast<std::size_t>(std::min(row, rows_ - 1)) * columns_ +
                    std::min(column, columns_ - 1)];
  }

  int columns_, rows_;
  std::vector<std::vector<int>> buckets_;
};

// Whether no point farther away can be among the nearest ones.
bool is_enough(const std::vector<Candidate>& list, double distance) {
  const auto nearer = [&](const Candidate& c) { return c.distance <= distance; };
  return static_cast<std::size_t>(std::ranges::count_if(list, nearer)) >= kMostCandidates;
}

// Whether a square of the buckets may have points that are within kAngle of a direction.
bool is_along(const Vector2d& direction, const Vector2d& to_middle) {
  constexpr double kHalf = 0.71 * PointBuckets::kSide;  // of the diagonal
  const double along = direction.dot(to_middle);
  const double across = direction.x() * to_middle.y() - direction.y() * to_middle.x();
  return along > -kHalf && std::abs(across) < std::tan(kAngle) * along + kHalf / std::cos(kAngle);
}

void keep_nearest(std::vector<Candidate>& list) {
  std::ranges::sort(list, [](const Candidate& a, const Candidate& b) {
    return std::pair(a.distance, a.point) < std::pair(b.distance, b.point);
  });
  list.resize(std::min(kMostCandidates, list.size()));
}

Candidates candidates_of(const std::vector<SaddlePoint>& points,
                         const std::vector<Directions>& directions, const PointBuckets& buckets,
                         std::size_t p) {
  Candidates result;
  std::array<bool, 4> open = {true, true, true, true};
  const auto wanted = [&](const Vector2d& to_middle) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (open[k] && is_along(directions[p][k], to_middle)) return true;
    }
    return false;
  };
  for (int ring = 0; ring < buckets.most_rings(); ++ring) {
    buckets.visit_ring(points[p].pixel, ring, wanted, [&](int q) {
      const auto other = static_cast<std::size_t>(q);
      const Vector2d way = points[other].pixel - points[p].pixel;
      const double length = way.norm();
      if (length < kLeastEdge) return;
      const auto edge = possible_edge(directions[p], directions[other], way, length);
      if (edge) result[static_cast<std::size_t>(edge->there)].push_back({length, q, edge->back});
    });
    for (std::size_t k = 0; k < 4; ++k) open[k] = !is_enough(result[k], ring * PointBuckets::kSide);
    if (std::ranges::none_of(open, std::identity())) break;
  }
  for (auto& list : result) keep_nearest(list);
  return result;
}

EdgeEnds find_edges(const GreyPlane& image, const std::vector<SaddlePoint>& points) {
  std::vector<Directions> directions;
  for (const SaddlePoint& point : points) directions.push_back(directions_of(point));
  const PointBuckets buckets(points, image.width, image.height);
  EdgeEnds nearest(points.size());
  for (std::size_t p = 0; p < points.size(); ++p) {
    const Candidates candidates = candidates_of(points, directions, buckets, p);
    for (std::size_t k = 0; k < 4; ++k) {
      for (const Candidate& c : candidates[k]) {
        const SaddlePoint& to = points[static_cast<std::size_t>(c.point)];
        if (!is_edge(image, points[p], to, k % 2 == 0)) continue;
        nearest[p][k] = {c.point, c.edge};
        break;
      }
    }
  }
  EdgeEnds mutual(points.size());
  for (std::size_t p = 0; p < points.size(); ++p) {
    for (std::size_t k = 0; k < 4; ++k) {
      const EdgeEnd to = nearest[p][k];
      if (to.point < 0) continue;
      const EdgeEnd back =
          nearest[static_cast<std::size_t>(to.point)][static_cast<std::size_t>(to.edge)];
      if (back.point == static_cast<int>(p) && back.edge == static_cast<int>(k)) mutual[p][k] = to;
    }
  }
  return mutual;
}

// Follows the border of the sector after direction `edge` of a point, clockwise.
std::optional<Quad> quad_at(const EdgeEnds& edges, int point, int edge) {
  Quad quad{.corners = {point}, .dark = edge % 2 == 0};
  EdgeEnd here{point, edge};
  for (std::size_t k = 1; k <= 4; ++k) {
    const EdgeEnd to =
        edges[static_cast<std::size_t>(here.point)][static_cast<std::size_t>(here.edge)];
    if (to.point < 0) return std::nullopt;
    here = {to.point, (to.edge + 3) % 4};
    if (k < 4) quad.corners[k] = here.point;
  }
  const bool closed = here.point == point && here.edge == edge;
  return closed ? std::optional(quad) : std::nullopt;
}

bool is_simple(const Quad& quad, const std::vector<SaddlePoint>& points) {
  for (std::size_t k = 0; k < 4; ++k) {
    const auto at = [&](std::size_t i) {
      return points[static_cast<std::size_t>(quad.corners[i % 4])].pixel;
    };
    const Vector2d a = at(k + 1) - at(k), b = at(k + 2) - at(k + 1);
    if (a.x() * b.y() - a.y() * b.x() < 0.15 * a.norm() * b.norm()) return false;
  }
  return true;
}

using QuadsOfEdges = std::map<std::pair<int, int>, std::vector<int>>;

QuadsOfEdges quads_of_edges(const std::vector<Quad>& quads) {
  QuadsOfEdges result;
  for (std::size_t i = 0; i < quads.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k) {
      const auto [a, b] = std::minmax(quads[i].corners[k], quads[i].corners[(k + 1) % 4]);
      result[{a, b}].push_back(static_cast<int>(i));
    }
  }
  return result;
}

// Places the corners of a quad, one edge of which (corner `first` and the next) has its place.
// Returns false where they contradict, and then changes nothing.
bool place(const Quad& quad, std::size_t first, CornerLattice& lattice) {
  const Vector2i a = lattice.positions.at(quad.corners[first]);
  const Vector2i b = lattice.positions.at(quad.corners[(first + 1) % 4]);
  const Vector2i inwards(-(b - a).y(), (b - a).x());  // clockwise by a quarter
  const std::array<std::pair<int, Vector2i>, 2> others = {
      std::pair(quad.corners[(first + 2) % 4], Vector2i(b + inwards)),
      std::pair(quad.corners[(first + 3) % 4], Vector2i(a + inwards))};
  for (const auto& [point, position] : others) {
    const auto known = lattice.positions.find(point);
    if (known != lattice.positions.end()) {
      if (known->second != position) return false;
      continue;
    }
    for (const auto& [other, taken] : lattice.positions) {
      if (taken == position) return false;
    }
  }
  for (const auto& [point, position] : others) lattice.positions.emplace(point, position);
  return true;
}

CornerLattice lattice_from(const std::vector<Quad>& quads, const QuadsOfEdges& neighbours,
                           std::size_t seed, std::vector<bool>& used) {
  CornerLattice lattice;
  const Quad& start = quads[seed];
  lattice.positions = {{start.corners[0], {0, 0}},
                       {start.corners[1], {1, 0}},
                       {start.corners[2], {1, 1}},
                       {start.corners[3], {0, 1}}};
  lattice.quads = {static_cast<int>(seed)};
  used[seed] = true;
  for (std::size_t next = 0; next < lattice.quads.size(); ++next) {
    const Quad& quad = quads[static_cast<std::size_t>(lattice.quads[next])];
    for (std::size_t k = 0; k < 4; ++k) {
      const int from = quad.corners[k], to = quad.corners[(k + 1) % 4];
      const auto [a, b] = std::minmax(from, to);
      for (const int other : neighbours.at({a, b})) {
        const Quad& neighbour = quads[static_cast<std::size_t>(other)];
        if (used[static_cast<std::size_t>(other)]) continue;
        // The neighbour runs along the edge the other way.
        const auto* const at = std::ranges::find(neighbour.corners, to);
        const auto first = static_cast<std::size_t>(at - neighbour.corners.begin());
        if (neighbour.corners[(first + 1) % 4] != from || !place(neighbour, first, lattice))
          continue;
        used[static_cast<std::size_t>(other)] = true;
        lattice.quads.push_back(other);
      }
    }
  }
  return lattice;
}

}  // namespace

std::vector<Quad> find_quads(const GreyPlane& image, const std::vector<SaddlePoint>& points) {
  const EdgeEnds edges = find_edges(image, points);
  std::vector<Quad> result;
  for (int p = 0; p < static_cast<int>(points.size()); ++p) {
    for (int k = 0; k < 4; ++k) {
      const auto quad = quad_at(edges, p, k);
      if (!quad || *std::ranges::min_element(quad->corners) != p) continue;
      if (is_simple(*quad, points)) result.push_back(*quad);
    }
  }
  return result;
}

bool is_connected(const GreyPlane& image, const SaddlePoint& from, const SaddlePoint& to) {
  const Vector2d way = to.pixel - from.pixel;
  const auto edge = possible_edge(directions_of(from), directions_of(to), way, way.norm());
  return edge && is_edge(image, from, to, edge->there % 2 == 0);
}

std::vector<CornerLattice> connect_quads(const std::vector<Quad>& quads) {
  const QuadsOfEdges neighbours = quads_of_edges(quads);
  std::vector<CornerLattice> result;
  std::vector<bool> used(quads.size(), false);
  for (std::size_t seed = 0; seed < quads.size(); ++seed) {
    if (!used[seed]) result.push_back(lattice_from(quads, neighbours, seed, used));
  }
  std::ranges::stable_sort(result, std::greater(),
                           [](const CornerLattice& l) { return l.quads.size(); });
  return result;
}

}  // namespace chasles
