#include <cmath>

#include <chasles/smooth/window/window_detail.hpp>

// The scale of a window relative to its prior (docs/window.md, section 2).
namespace chasles::smooth_detail {
namespace {

using Vector3d = Eigen::Vector3d;

// A landmark with a larger relative sigma of its depth, all else given, does not count for the
// scale.
constexpr double kMostRelativeSigma = 0.1;

Eigen::Map<const Vector3d> position(const WindowKeyframe& keyframe) {
  return Eigen::Map<const Vector3d>(keyframe.motion.data() + 9);
}

Eigen::Map<const Vector3d> velocity(const WindowKeyframe& keyframe) {
  return Eigen::Map<const Vector3d>(keyframe.motion.data() + kPoseNumbers);
}

// The logarithm of the distance to which a landmark's relative error refers, and its derivatives by
// the landmark's parameters and by the position from which it is measured.
struct LogDepth {
  double value = 0;
  Vector3d by_point = Vector3d::Zero(), by_position = Vector3d::Zero();
};

LogDepth log_depth(const Window& window, const Vector3d& parameters, const Vector3d& from) {
  LogDepth depth;
  if (window.anchored) {
    depth.value = -std::log(parameters.z());  // NaN behind the camera: no step is accepted there
    depth.by_point.z() = -1 / parameters.z();
    return depth;
  }
  const Vector3d way = parameters - from;
  depth.value = std::log(way.norm());
  depth.by_point = way / way.squaredNorm();
  depth.by_position = -depth.by_point;
  return depth;
}

}  // namespace

void weigh_scale(const Window& window, WindowPrior& prior) {
  if (!window.sizes.velocity) return;
  const Vector3d from = position(prior.keyframes.back());
  double sum = 0;
  for (const auto& [number, row] : prior_rows(window).points) {
    const Vector3d& parameters = prior.points.at(number);
    if (window.anchored && !(parameters.z() > 0)) continue;
    const LogDepth depth = log_depth(window, parameters, from);
    // Along the ray, with all other parameters fixed.
    const Vector3d along = depth.by_point / depth.by_point.squaredNorm();
    const Eigen::Matrix3d block =
        prior.information.block<3, 3>(row, row).selfadjointView<Eigen::Lower>();
    const double information = along.dot(block * along);
    if (!(information * kMostRelativeSigma * kMostRelativeSigma > 1)) continue;
    prior.scale_weights.emplace(number, information);
    sum += information;
  }
  for (auto& [number, weight] : prior.scale_weights) weight /= sum;
}

WindowScale scale_of(const Window& window, const WindowRows& rows) {
  const WindowPrior& prior = window.prior;
  WindowScale scale{.by_errors = Eigen::VectorXd::Zero(rows.size)};
  if (prior.scale_weights.empty()) return scale;
  const auto newest = std::ssize(prior.keyframes) - 1;
  const Vector3d from = position(window.keyframes[static_cast<std::size_t>(newest)]);
  const Vector3d from_before = position(prior.keyframes.back());
  for (const auto& [number, weight] : prior.scale_weights) {
    const LogDepth now = log_depth(window, window.points.at(number).parameters, from);
    scale.log +=
        weight * (now.value - log_depth(window, prior.points.at(number), from_before).value);
    scale.by_errors.segment<3>(rows.points.at(number)) = weight * now.by_point;
    scale.by_errors.segment<3>(rows.keyframe(window.first + static_cast<int>(newest)) + 3) +=
        weight * now.by_position;
  }
  return scale;
}

ScaledNumbers scaled(const Window& window, double log) {
  const WindowPrior& prior = window.prior;
  ScaledNumbers numbers;
  if (prior.keyframes.empty()) return numbers;
  const Vector3d about = position(prior.keyframes.front());
  const double factor = std::exp(log);
  for (std::size_t k = 0; k < prior.keyframes.size(); ++k) {
    numbers.keyframes.push_back(window.keyframes[k]);
    if (log == 0) continue;
    double* motion = numbers.keyframes.back().motion.data();
    Eigen::Map<Vector3d> p(motion + 9), v(motion + kPoseNumbers);
    p = about + factor * (p - about);
    v *= factor;
  }
  for (const auto& [number, at] : prior.points) {
    Vector3d parameters = window.points.at(number).parameters;
    if (log != 0 && window.anchored) parameters.z() /= factor;
    if (log != 0 && !window.anchored) parameters = about + factor * (parameters - about);
    numbers.points.emplace(number, parameters);
  }
  return numbers;
}

Eigen::VectorXd scale_direction(const Window& window, const WindowRows& rows,
                                const ScaledNumbers& numbers) {
  Eigen::VectorXd s = Eigen::VectorXd::Zero(rows.size);
  const Vector3d about = position(window.prior.keyframes.front());
  int k = rows.first;
  for (const WindowKeyframe& keyframe : numbers.keyframes) {
    const int row = rows.keyframe(k);
    s.segment<3>(row + 3) = position(keyframe) - about;
    if (rows.errors_of(k++) > kPoseErrors) s.segment<3>(row + kPoseErrors) = velocity(keyframe);
  }
  for (const auto& [number, parameters] : numbers.points) {
    if (window.anchored) {
      s[rows.points.at(number) + 2] = -parameters.z();
    } else {
      s.segment<3>(rows.points.at(number)) = parameters - about;
    }
  }
  return s;
}

Eigen::VectorXd scaling(const Window& window, const WindowRows& rows, double log) {
  Eigen::VectorXd E = Eigen::VectorXd::Ones(rows.size);
  const double factor = std::exp(log);
  for (int k = rows.first; k < rows.first + rows.keyframes; ++k) {
    const int moved = rows.errors_of(k) > kPoseErrors ? 6 : 3;  // the position, and the velocity
    E.segment(rows.keyframe(k) + 3, moved).setConstant(factor);
  }
  for (const auto& [number, row] : rows.points) {
    if (window.anchored) {
      E[row + 2] = 1 / factor;
    } else {
      E.segment<3>(row).setConstant(factor);
    }
  }
  return E;
}

}  // namespace chasles::smooth_detail
