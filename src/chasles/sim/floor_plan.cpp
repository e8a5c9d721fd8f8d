#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include <chasles/sim/floor_plan.hpp>

namespace chasles {
namespace {

constexpr double kSame = 1e-6;  // [m]

// The plan on the grid of all its edges: each cell is either free or solid.
struct Grid {
  std::array<std::vector<double>, 2> edges;
  std::vector<char> free;

  int columns() const { return static_cast<int>(edges[0].size()) - 1; }
  int rows() const { return static_cast<int>(edges[1].size()) - 1; }
  double x(int i) const { return edges[0][static_cast<std::size_t>(i)]; }
  double y(int j) const { return edges[1][static_cast<std::size_t>(j)]; }
  std::size_t cell(int i, int j) const { return static_cast<std::size_t>(j * columns() + i); }
  bool is_free(int i, int j) const {
    return i >= 0 && j >= 0 && i < columns() && j < rows() && free[cell(i, j)] != 0;
  }
};

bool contains(const FloorPlan& plan, const Eigen::Vector2d& p) {
  return std::ranges::any_of(plan.rooms, [&](const PlanRectangle& room) {
    return (p.array() > room.low.array()).all() && (p.array() < room.high.array()).all();
  });
}

Grid make_grid(const FloorPlan& plan) {
  Grid grid;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    auto& edges = grid.edges[axis];
    for (const PlanRectangle& room : plan.rooms) {
      edges.push_back(room.low[static_cast<Eigen::Index>(axis)]);
      edges.push_back(room.high[static_cast<Eigen::Index>(axis)]);
    }
    std::ranges::sort(edges);
    const auto same = [](double a, double b) { return b - a < kSame; };
    edges.erase(std::unique(edges.begin(), edges.end(), same), edges.end());
  }
  for (int j = 0; j < grid.rows(); ++j) {
    for (int i = 0; i < grid.columns(); ++i) {
      const Eigen::Vector2d middle(grid.x(i) + grid.x(i + 1), grid.y(j) + grid.y(j + 1));
      grid.free.push_back(contains(plan, middle / 2) ? 1 : 0);
    }
  }
  return grid;
}

// Calls found(begin, end, side) for each longest run of edges where free(k) - free'(k) is the same
// side, +1 or -1.
void runs(int count, const std::function<int(int)>& side_at,
          const std::function<void(int, int, int)>& found) {
  for (int begin = 0; begin < count;) {
    const int side = side_at(begin);
    int end = begin + 1;
    while (end < count && side_at(end) == side) ++end;
    if (side != 0) found(begin, end, side);
    begin = end;
  }
}

int difference(bool here, bool there) { return static_cast<int>(here) - static_cast<int>(there); }

// Cells of one kind, joined to rectangles: first as far right, then as far up as possible.
std::vector<PlanRectangle> joined(const Grid& grid, bool free) {
  std::vector<PlanRectangle> result;
  std::vector<char> taken(grid.free.size(), 0);
  const auto open = [&](int i, int j) {
    return grid.is_free(i, j) == free && taken[grid.cell(i, j)] == 0;
  };
  for (int j = 0; j < grid.rows(); ++j) {
    for (int i = 0; i < grid.columns(); ++i) {
      if (!open(i, j)) continue;
      int right = i + 1, top = j + 1;
      while (right < grid.columns() && open(right, j)) ++right;
      const auto row_open = [&](int row) {
        for (int k = i; k < right; ++k) {
          if (!open(k, row)) return false;
        }
        return true;
      };
      while (top < grid.rows() && row_open(top)) ++top;
      for (int row = j; row < top; ++row) {
        for (int k = i; k < right; ++k) taken[grid.cell(k, row)] = 1;
      }
      result.push_back({{grid.x(i), grid.y(j)}, {grid.x(right), grid.y(top)}});
    }
  }
  return result;
}

}  // namespace

std::vector<WallSegment> plan_walls(const FloorPlan& plan) {
  const Grid grid = make_grid(plan);
  std::vector<WallSegment> walls;
  for (int j = 0; j <= grid.rows(); ++j) {
    runs(
        grid.columns(),
        [&](int i) { return difference(grid.is_free(i, j), grid.is_free(i, j - 1)); },
        [&](int begin, int end, int side) {
          const Eigen::Vector2d low(grid.x(begin), grid.y(j)), high(grid.x(end), grid.y(j));
          walls.push_back(side > 0 ? WallSegment{low, high} : WallSegment{high, low});
        });
  }
  for (int i = 0; i <= grid.columns(); ++i) {
    runs(
        grid.rows(), [&](int j) { return difference(grid.is_free(i, j), grid.is_free(i - 1, j)); },
        [&](int begin, int end, int side) {
          const Eigen::Vector2d low(grid.x(i), grid.y(begin)), high(grid.x(i), grid.y(end));
          walls.push_back(side > 0 ? WallSegment{high, low} : WallSegment{low, high});
        });
  }
  return walls;
}

std::vector<std::vector<Eigen::Vector2d>> wall_loops(const std::vector<WallSegment>& walls) {
  // The corners are points of one grid: two walls that meet have identical numbers.
  const auto corner = [](const Eigen::Vector2d& p) { return std::pair(p.x(), p.y()); };
  std::multimap<std::pair<double, double>, const WallSegment*> beginning;
  for (const WallSegment& wall : walls) beginning.emplace(corner(wall.a), &wall);
  std::vector<std::vector<Eigen::Vector2d>> loops;
  while (!beginning.empty()) {
    auto& loop = loops.emplace_back();
    loop.push_back(beginning.begin()->second->a);
    for (auto next = beginning.begin(); next != beginning.end();
         next = beginning.find(corner(loop.back()))) {
      loop.push_back(next->second->b);
      beginning.erase(next);
    }
  }
  return loops;
}

std::vector<PlanRectangle> plan_floors(const FloorPlan& plan) {
  return joined(make_grid(plan), true);
}

std::vector<PlanRectangle> plan_solids(const FloorPlan& plan) {
  return joined(make_grid(plan), false);
}

double distance_to_walls(const std::vector<WallSegment>& walls, const Eigen::Vector2d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const WallSegment& wall : walls) {
    const Eigen::Vector2d nearest =
        p.cwiseMax(wall.a.cwiseMin(wall.b)).cwiseMin(wall.a.cwiseMax(wall.b));
    least = std::min(least, (p - nearest).norm());
  }
  return least;
}

}  // namespace chasles
