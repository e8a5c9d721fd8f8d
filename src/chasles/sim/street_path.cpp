#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/sim/smoothstep.hpp>
#include <chasles/sim/street_path.hpp>

namespace chasles {
namespace {

constexpr double kQuarter = std::numbers::pi / 2;
constexpr double kStreetClearance =
    1.5;  // from the IMU to the house at the corner [m]: half a car, and air

Eigen::Vector2d direction(double heading) { return {std::cos(heading), std::sin(heading)}; }

// The displacement over the first `way` metres of a corner, in axes of its first heading.
Eigen::Vector2d corner_displacement(double way, double length, double turn) {
  // Gauss-Legendre with five points on each of eight panels.
  static constexpr std::array kNodes = {0.0, 0.53846931010568309, 0.90617984593866399};
  static constexpr std::array kWeights = {128.0 / 225, 0.47862867049936647, 0.23692688505618909};
  constexpr int kPanels = 8;
  const double half = way / (2 * kPanels);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (int panel = 0; panel < kPanels; ++panel) {
    const double middle = (2 * panel + 1) * half;
    for (std::size_t i = 0; i < kNodes.size(); ++i) {
      const double weight = i == 0 ? kWeights[i] / 2 : kWeights[i];
      for (const double sign : {-1.0, 1.0}) {
        sum += weight * direction(turn * smoothstep((middle + sign * half * kNodes[i]) / length));
      }
    }
  }
  return half * sum;
}

// The distance from a crossing to the start, and to the end, of its corner [m].
double corner_reach(double length) { return corner_displacement(length, length, kQuarter).x(); }

void check_corner(const StreetSettings& settings) {
  if (settings.route.find_first_of("LR") == std::string::npos) return;
  const double reach = corner_reach(settings.corner_length);
  const double block = std::min(settings.block_length, settings.block_width);
  if (2 * reach > block) {
    throw UsageError(fmt::format(
        "simulation setting corner_length = {} m: two such corners take {:.1f} m of a street of {} "
        "m; expected a shorter corner or a longer block_length and block_width",
        settings.corner_length, 2 * reach, block));
  }
  const double inward =
      corner_displacement(settings.corner_length / 2, settings.corner_length, kQuarter).y();
  if (inward + kStreetClearance > settings.street_width / 2) {
    throw UsageError(fmt::format(
        "simulation setting street_width = {} m: a corner of corner_length = {} m comes nearer "
        "than {} m to the house inside it; expected a street of {:.1f} m or a shorter corner",
        settings.street_width, settings.corner_length, kStreetClearance,
        2 * (inward + kStreetClearance)));
  }
}

void append(StreetPath& path, double length, double turn) {
  PathPiece piece{.start = path.length, .length = length, .turn = turn};
  if (!path.pieces.empty()) {
    const PathPoint end = point_at(path, path.length);
    piece.p = end.p;
    piece.heading = path.pieces.back().heading + path.pieces.back().turn;
  }
  path.pieces.push_back(piece);
  path.length += length;
}

}  // namespace

StreetPath make_street_path(const StreetSettings& settings) {
  check_corner(settings);
  const double reach = corner_reach(settings.corner_length);
  StreetPath path;
  Eigen::Vector2i crossing(0, 0), step(1, 0);
  path.crossings.push_back(crossing);
  double straight = 0;
  const auto next_crossing = [&] {
    crossing += step;
    path.crossings.push_back(crossing);
    straight += step.x() != 0 ? settings.block_length : settings.block_width;
  };
  next_crossing();
  for (const char letter : settings.route) {
    if (letter != 'S') {
      const int side = letter == 'L' ? 1 : -1;
      append(path, straight - reach, 0);
      append(path, settings.corner_length, side * kQuarter);
      straight = -reach;
      step = Eigen::Vector2i(-side * step.y(), side * step.x());
    }
    next_crossing();
  }
  append(path, straight, 0);
  return path;
}

PathPoint point_at(const StreetPath& path, double way) {
  const auto after = std::ranges::upper_bound(path.pieces, way, {}, &PathPiece::start);
  const PathPiece& piece = after == path.pieces.begin() ? *after : *std::prev(after);
  const double along = way - piece.start;
  if (piece.turn == 0) {
    return {piece.p + along * direction(piece.heading), piece.heading, 0};
  }
  const Eigen::Vector2d ahead = direction(piece.heading);
  const Eigen::Vector2d left(-ahead.y(), ahead.x());
  const Eigen::Vector2d moved = corner_displacement(along, piece.length, piece.turn);
  const double x = along / piece.length;
  return {piece.p + moved.x() * ahead + moved.y() * left,
          piece.heading + piece.turn * smoothstep(x),
          piece.turn / piece.length * smoothstep_derivative(x)};
}

}  // namespace chasles
