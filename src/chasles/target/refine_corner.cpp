#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Cholesky>

#include <chasles/target/refine_corner.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;
using Parameters = Eigen::Matrix<double, 7, 1>;
using Normal = Eigen::Matrix<double, 7, 7>;

// The parameters: the corner (2), the angles of the edges (2), the middle grey value, half of the
// contrast, and the blur.
enum Index { kX, kY, kFirst, kSecond, kMiddle, kHalf, kBlur };

constexpr double kLeastBlur = 0.25;  // [px]: a pixel's own width is 0.29

struct Sample {
  Vector2d pixel;
  double grey = 0, weight = 0;
};

std::vector<Sample> samples_around(const GreyPlane& image, const Vector2d& middle, double radius) {
  std::vector<Sample> result;
  for (int y = static_cast<int>(std::ceil(middle.y() - radius)); y <= middle.y() + radius; ++y) {
    for (int x = static_cast<int>(std::ceil(middle.x() - radius)); x <= middle.x() + radius; ++x) {
      const double part = (Vector2d(x, y) - middle).squaredNorm() / (radius * radius);
      // Less weight where other edges are near.
      if (part < 1)
        result.push_back({Vector2d(x, y), static_cast<double>(image.row(y)[x]), 1 - part * part});
    }
  }
  return result;
}

// A blurred edge: from -1 to 1 across a line through the corner, and its derivatives.
struct BlurredEdge {
  double value = 0, d_distance = 0, along = 0, distance = 0;
  Vector2d normal;
};

BlurredEdge edge_at(const Vector2d& from_corner, const Vector2d& direction, double blur) {
  BlurredEdge edge;
  edge.normal = Vector2d(-direction.y(), direction.x());
  edge.along = direction.dot(from_corner);
  edge.distance = edge.normal.dot(from_corner);
  const double t = edge.distance / blur;
  edge.value = std::erf(t / std::numbers::sqrt2);
  edge.d_distance = std::sqrt(2 / std::numbers::pi) / blur * std::exp(-t * t / 2);
  return edge;
}

// The crossing with given parameters.
class Crossing {
 public:
  explicit Crossing(const Parameters& p)
      : p_(p),
        first_(std::cos(p(kFirst)), std::sin(p(kFirst))),
        second_(std::cos(p(kSecond)), std::sin(p(kSecond))) {}

  // The grey value at a pixel, and its derivative by the parameters where it is wanted.
  double at(const Vector2d& pixel, Parameters* derivative) const {
    const Vector2d from_corner = pixel - p_.head<2>();
    const BlurredEdge a = edge_at(from_corner, first_, p_(kBlur));
    const BlurredEdge b = edge_at(from_corner, second_, p_(kBlur));
    if (derivative != nullptr) {
      const double d_a = p_(kHalf) * b.value * a.d_distance;
      const double d_b = p_(kHalf) * a.value * b.d_distance;
      derivative->head<2>() = -d_a * a.normal - d_b * b.normal;
      (*derivative)(kFirst) = -d_a * a.along;
      (*derivative)(kSecond) = -d_b * b.along;
      (*derivative)(kMiddle) = 1;
      (*derivative)(kHalf) = a.value * b.value;
      (*derivative)(kBlur) = -(d_a * a.distance + d_b * b.distance) / p_(kBlur);
    }
    return p_(kMiddle) + p_(kHalf) * a.value * b.value;
  }

 private:
  const Parameters& p_;
  Vector2d first_, second_;
};

// The sum of weighted squares, and the normal equations where they are wanted.
double cost_of(const std::vector<Sample>& samples, const Parameters& p, Normal* normal,
               Parameters* right) {
  const Crossing crossing(p);
  double cost = 0;
  Parameters row;
  for (const Sample& s : samples) {
    const double residual = s.grey - crossing.at(s.pixel, normal != nullptr ? &row : nullptr);
    cost += s.weight * residual * residual;
    if (normal == nullptr) continue;
    normal->selfadjointView<Eigen::Lower>().rankUpdate(row, s.weight);
    *right += s.weight * residual * row;
  }
  return cost;
}

struct Fit {
  Parameters parameters;
  Normal normal;  // lower half
  double cost = 0;
};

Fit fitted(const std::vector<Sample>& samples, const Parameters& start) {
  constexpr int kIterations = 12;
  constexpr double kConverged = 1e-3;  // [px], grey values
  Fit fit{start, Normal::Zero(), 0};
  double damping = 1e-3;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    fit.normal.setZero();
    Parameters right = Parameters::Zero();
    fit.cost = cost_of(samples, fit.parameters, &fit.normal, &right);
    Normal damped = fit.normal;
    damped.diagonal() *= 1 + damping;
    const Parameters step = damped.selfadjointView<Eigen::Lower>().ldlt().solve(right);
    Parameters next = fit.parameters + step;
    next(kBlur) = std::max(next(kBlur), kLeastBlur);
    if (!next.allFinite()) break;
    const bool better = cost_of(samples, next, nullptr, nullptr) <= fit.cost;
    damping *= better ? 0.1 : 10;
    if (better) fit.parameters = next;
    if (better && step.head<2>().norm() < kConverged) break;
  }
  return fit;
}

}  // namespace

std::optional<RefinedCorner> refined_corner(const GreyPlane& image, const SaddlePoint& point,
                                            double radius) {
  constexpr double kMisfit = 0.35;  // of half the contrast: cameras sharpen edges, and clip white
  constexpr double kWorstSigma = 0.15;  // [px]: five times that of an ordinary corner
  if (!image.contains(point.pixel, radius)) return std::nullopt;
  const std::vector<Sample> samples = samples_around(image, point.pixel, radius);
  Parameters start;
  start << point.pixel, point.edges[0], point.edges[1], (point.dark + point.light) / 2,
      (point.light - point.dark) / 2, std::clamp(point.blur, 0.4, radius / 2);
  const Fit fit = fitted(samples, start);
  const Parameters& p = fit.parameters;
  double weights = 0;
  for (const Sample& s : samples) weights += s.weight;
  const double misfit = std::sqrt(fit.cost / weights);
  if ((p.head<2>() - point.pixel).norm() > radius / 2 || p(kBlur) > radius ||
      misfit > kMisfit * p(kHalf)) {
    return std::nullopt;
  }
  const Normal inverse =
      Normal(fit.normal.selfadjointView<Eigen::Lower>()).ldlt().solve(Normal::Identity());
  const double variance = misfit * misfit * (inverse(0, 0) + inverse(1, 1)) / 2;
  if (!(variance >= 0 && variance < kWorstSigma * kWorstSigma)) return std::nullopt;
  return RefinedCorner{p.head<2>(), std::sqrt(variance), p(kBlur)};
}

}  // namespace chasles
