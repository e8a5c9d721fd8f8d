#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <chasles/target/corner_lattice.hpp>
#include <chasles/target/corner_neighbours.hpp>
#include <chasles/target/local_homography.hpp>
#include <chasles/target/tag_layout.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using Place = std::pair<int, int>;

// Of the distance to the nearest neighbour. At the border of a board in a wide lens the prediction
// is off by a quarter of it.
constexpr double kMisplaced = 0.5, kFits = 0.3;
constexpr int kReach = 2;  // columns and rows to the farthest neighbour
constexpr std::size_t kLeastNeighbours = 6;

// The corners' places on the board.
class BoardPlaces {
 public:
  explicit BoardPlaces(const Target& target) : target_(target), corners_(target.corners()) {}

  Vector2d operator()(const Place& place) const {
    return corners_[static_cast<std::size_t>(corner_id(target_, {place.first, place.second}))]
        .head<2>();
  }

 private:
  const Target& target_;
  std::vector<Eigen::Vector3d> corners_;
};

// Where the neighbours have a corner, and how near the nearest one is there.
struct Prediction {
  Vector2d pixel;
  double spacing = 0;  // [px]
};

std::optional<Prediction> predicted(const BoardPlaces& places, const FoundCorners& corners,
                                    const Place& place) {
  std::vector<BoardPixel> around;
  for (int dy = -kReach; dy <= kReach; ++dy) {
    for (int dx = -kReach; dx <= kReach; ++dx) {
      const auto found = corners.find({place.first + dx, place.second + dy});
      if (found == corners.end() || (dx == 0 && dy == 0)) continue;
      around.push_back({places(found->first), found->second.pixel});
    }
  }
  if (around.size() < kLeastNeighbours) return std::nullopt;
  const Vector2d here = places(place);
  const auto H = local_homography(around);
  if (!H) return std::nullopt;
  const Eigen::Vector3d p = *H * here.homogeneous();
  if (!(p.z() > 0) && !(p.z() < 0)) return std::nullopt;
  Prediction result{p.hnormalized(), std::numeric_limits<double>::infinity()};
  for (const BoardPixel& other : around) {
    result.spacing = std::min(result.spacing, (other.pixel - result.pixel).norm());
  }
  return result;
}

constexpr std::array<Place, 4> kSteps = {Place(1, 0), Place(-1, 0), Place(0, 1), Place(0, -1)};

// How far the next thing is, as a part of the way to the next corner; not wholly, as blur spreads.
double free_part(const Target& target, const Place& place, const Place& step) {
  constexpr double kOfWay = 0.45;
  if (target.kind == TargetKind::checkerboard) return kOfWay;
  if (target.kind == TargetKind::charuco) {  // the corner of a marker is diagonal
    return std::min(kOfWay, 0.6 * (1 - target.tag_size / target.column_spacing));
  }
  const int along = step.first != 0 ? place.first : place.second;
  const bool along_tag = (along % 2 == 0) == (step.first + step.second > 0);
  return along_tag ? kOfWay * std::min(1.0, target.tag_spacing)
                   : kOfWay * std::min(1.0, 0.6 / target.tag_spacing);
}

// Whether the corners on both sides are there, along the columns or the rows: in a wide lens, what
// is outside of them may be one corner off.
bool is_between(const FoundCorners& corners, const Place& place) {
  const auto [x, y] = place;
  return (corners.contains({x - 1, y}) && corners.contains({x + 1, y})) ||
         (corners.contains({x, y - 1}) && corners.contains({x, y + 1}));
}

// Whether the point is where the corner must be, with edges to the next corners.
bool fits(const GreyPlane& image, const FoundCorners& corners, const Place& place,
          const Prediction& prediction, const SaddlePoint& point) {
  if ((point.pixel - prediction.pixel).norm() > kFits * prediction.spacing) return false;
  int edges = 0;
  for (const Place& step : kSteps) {
    const auto next = corners.find({place.first + step.first, place.second + step.second});
    if (next != corners.end() && is_connected(image, point, next->second)) ++edges;
  }
  return edges >= 2;
}

bool is_taken(const FoundCorners& corners, const SaddlePoint& point) {
  return std::ranges::any_of(
      corners, [&](const auto& found) { return (found.second.pixel - point.pixel).norm() < 2; });
}

}  // namespace

void remove_misplaced(const Target& target, FoundCorners& corners) {
  const BoardPlaces places(target);
  std::vector<Place> misplaced;
  for (const auto& [place, point] : corners) {
    const auto prediction = predicted(places, corners, place);
    if (!prediction) continue;
    if ((point.pixel - prediction->pixel).norm() > kMisplaced * prediction->spacing) {
      misplaced.push_back(place);
    }
  }
  for (const Place& place : misplaced) corners.erase(place);
}

void add_missing(const Target& target, const GreyPlane& image,
                 const std::vector<SaddlePoint>& points, FoundCorners& corners) {
  const BoardPlaces places(target);
  const CornerGrid grid = corner_grid(target);
  for (std::size_t before = 0; before != corners.size();) {
    before = corners.size();
    for (int row = 0; row < grid.rows; ++row) {
      for (int column = 0; column < grid.columns; ++column) {
        const Place place(column, row);
        if (corners.contains(place) || !is_between(corners, place)) continue;
        const auto prediction = predicted(places, corners, place);
        if (!prediction) continue;
        for (const SaddlePoint& point : points) {
          if (!fits(image, corners, place, *prediction, point) || is_taken(corners, point))
            continue;
          corners.emplace(place, point);
          break;
        }
      }
    }
  }
}

std::map<Place, double> free_radii(const Target& target, const FoundCorners& corners) {
  std::map<Place, double> result;
  for (const auto& [place, point] : corners) {
    double least = std::numeric_limits<double>::infinity();
    for (const Place& step : kSteps) {
      const auto next = corners.find({place.first + step.first, place.second + step.second});
      if (next == corners.end()) continue;
      const double part = free_part(target, place, step);
      least = std::min(least, part * (next->second.pixel - point.pixel).norm());
    }
    result.emplace(place, least);
  }
  return result;
}

std::vector<double> spacings(const FoundCorners& corners) {
  std::vector<double> result;
  for (const auto& [place, point] : corners) {
    double least = std::numeric_limits<double>::infinity();
    for (const Place& step : kSteps) {
      const auto next = corners.find({place.first + step.first, place.second + step.second});
      if (next != corners.end()) least = std::min(least, (next->second.pixel - point.pixel).norm());
    }
    if (std::isfinite(least)) result.push_back(least);
  }
  return result;
}

}  // namespace chasles
