#include <algorithm>
#include <cmath>
#include <limits>

#include <chasles/base/constants.hpp>
#include <chasles/eval/ate.hpp>

namespace chasles {
Statistics statistics(std::vector<double> magnitudes) {
  Statistics s;
  s.count = magnitudes.size();
  if (magnitudes.empty()) {
    s.rmse = s.mean = s.median = s.max = std::numeric_limits<double>::quiet_NaN();
    return s;
  }
  const auto n = static_cast<double>(magnitudes.size());
  double squares = 0;
  for (const double x : magnitudes) {
    s.mean += x / n;
    squares += x * x / n;
  }
  s.rmse = std::sqrt(squares);
  const auto middle = magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 2);
  std::nth_element(magnitudes.begin(), middle, magnitudes.end());
  s.median = *middle;
  if (magnitudes.size() % 2 == 0) {
    s.median = (s.median + *std::max_element(magnitudes.begin(), middle)) / 2;
  }
  s.max = *std::max_element(middle, magnitudes.end());
  return s;
}

std::vector<StampedError> pose_errors(const MatchedTrajectories& matched,
                                      const WorldAlignment& alignment) {
  std::vector<StampedError> errors;
  errors.reserve(matched.truth.size());
  for (std::size_t i = 0; i < matched.truth.size(); ++i) {
    const SE3& truth = matched.truth[i].pose;
    const SE3 estimate = alignment(matched.estimate[i].pose);
    errors.push_back({.time = matched.estimate[i].time,
                      .attitude = so3::log(truth.R * estimate.R.transpose()),
                      .position = truth.p - estimate.p});
  }
  return errors;
}

AbsoluteError absolute_error(const MatchedTrajectories& matched, Alignment alignment) {
  AbsoluteError result{.alignment = alignment,
                       .transform = align(matched, alignment),
                       .position_m = {},
                       .attitude_deg = {}};
  std::vector<double> positions;
  std::vector<double> attitudes;
  for (const StampedError& error : pose_errors(matched, result.transform)) {
    positions.push_back(error.position.norm());
    attitudes.push_back(kDegrees * error.attitude.norm());
  }
  result.position_m = statistics(std::move(positions));
  result.attitude_deg = statistics(std::move(attitudes));
  return result;
}

}  // namespace chasles
