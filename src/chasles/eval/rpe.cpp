#include <cmath>

#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/eval/rpe.hpp>

namespace chasles {
namespace {

struct Piece {
  std::size_t first, last;
};

void require(bool condition, double value, const char* what) {
  if (!condition) {
    throw UsageError(fmt::format("relative error: {} is {}, expected a positive one", what, value));
  }
}

SE3 difference(const MatchedTrajectories& matched, Piece piece) {
  const auto delta = [&](const Trajectory& trajectory) {
    return trajectory[piece.first].pose.inverse() * trajectory[piece.last].pose;
  };
  return delta(matched.estimate).inverse() * delta(matched.truth);
}

// translation = |error| * translation_unit, and the same for the angle in degrees.
RelativeError summarize(const MatchedTrajectories& matched, const std::vector<Piece>& pieces,
                        double length, double translation_unit, double rotation_unit) {
  std::vector<double> translations;
  std::vector<double> rotations;
  for (const Piece& piece : pieces) {
    const SE3 error = difference(matched, piece);
    translations.push_back(translation_unit * error.p.norm());
    rotations.push_back(rotation_unit * kDegrees * so3::log(error.R).norm());
  }
  return {.length = length,
          .translation = statistics(std::move(translations)),
          .rotation = statistics(std::move(rotations))};
}

std::vector<Piece> pieces_of_distance(const std::vector<double>& distances, double length,
                                      std::size_t step) {
  std::vector<Piece> pieces;
  std::size_t last = 0;
  for (std::size_t first = 0; first < distances.size(); first += step) {
    while (last < distances.size() && distances[last] <= distances[first] + length) ++last;
    if (last == distances.size()) break;
    pieces.push_back({first, last});
  }
  return pieces;
}

std::vector<Piece> pieces_of_time(const Trajectory& truth, Time interval, std::size_t step) {
  const Time tolerance = median_spacing(truth) / 2;
  std::vector<Piece> pieces;
  std::size_t last = 0;
  for (std::size_t first = 0; first < truth.size(); first += step) {
    const Time end = truth[first].time + interval;
    const auto miss = [&](std::size_t i) { return std::chrono::abs(truth[i].time - end); };
    while (last + 1 < truth.size() && miss(last + 1) <= miss(last)) ++last;
    if (miss(last) <= tolerance && last > first) pieces.push_back({first, last});
  }
  return pieces;
}

}  // namespace

std::vector<RelativeError> relative_error_over_distance(const MatchedTrajectories& matched,
                                                        const RelativeErrorOptions& options) {
  require(options.step >= 1, options.step, "the step");
  const std::vector<double> distances = distances_along(matched.truth);
  std::vector<RelativeError> result;
  for (const double length : options.distances_m) {
    require(length > 0, length, "a distance");
    const auto pieces =
        pieces_of_distance(distances, length, static_cast<std::size_t>(options.step));
    result.push_back(summarize(matched, pieces, length, 100 / length, 1 / length));
  }
  return result;
}

std::vector<RelativeError> relative_error_over_time(const MatchedTrajectories& matched,
                                                    const RelativeErrorOptions& options) {
  require(options.step >= 1, options.step, "the step");
  std::vector<RelativeError> result;
  for (const double interval : options.intervals_s) {
    require(interval > 0, interval, "an interval");
    const auto pieces = pieces_of_time(matched.truth, from_seconds(interval),
                                       static_cast<std::size_t>(options.step));
    result.push_back(summarize(matched, pieces, interval, 1, 1));
  }
  return result;
}

}  // namespace chasles
