#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/codec/image_decode.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/viewers/colours.hpp>
#include <chasles/viewers/foxglove.hpp>
#include <chasles/viewers/image_messages.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;
using Points = std::vector<Eigen::Vector2d>;

// Of foxglove.PointsAnnotation.
enum class MarkKind { kPoints = 1, kLoop = 2, kLines = 4 };

constexpr double kMark = 3;    // half the size of a mark [px]
constexpr double kSigmas = 3;  // of an ellipse
constexpr int kCorners = 16;   // of an ellipse

Json json_of(const Eigen::Vector2d& p) { return {{"x", p.x()}, {"y", p.y()}}; }

// The factor from the camera's pixels to those of the picture.
double scale_of(const ShownImage& image) {
  if (image.jpeg.empty() || image.width == 0) return 1;
  return static_cast<double>(stated_size(image.jpeg, "a kept image").width) / image.width;
}

/// The annotations of one image.
class Annotations {
 public:
  Annotations(Time time, double scale) : time_(time), scale_(scale) {}

  void add(const ImageFeature& feature) {
    const Eigen::Vector2d at = feature.seen.observation.pixel;
    if (feature.before) polygon(MarkKind::kLines, feature.seen.outcome, {at, *feature.before});
    if (feature.seen.expected) {
      polygon(MarkKind::kLoop, feature.seen.outcome,
              ellipse_points(*feature.seen.expected, kSigmas));
    }
    mark(feature.seen.outcome, at);
  }

  Json json() && {
    return {{"timestamp", proto_time(time_)},
            {"circles", std::move(circles_)},
            {"points", std::move(points_)}};
  }

 private:
  void mark(Outcome outcome, const Eigen::Vector2d& at) {
    const double h = kMark / scale_;
    const auto corner = [&](double x, double y) -> Eigen::Vector2d {
      return at + h * Eigen::Vector2d(x, y);
    };
    switch (outcome) {
      case Outcome::kUsed:
        circles_.push_back({{"timestamp", proto_time(time_)},
                            {"position", json_of(scale_ * at)},
                            {"diameter", 2 * kMark},
                            {"thickness", 1.0},
                            {"outline_color", proto_colour(outcome_colour(outcome), 1)}});
        return;
      case Outcome::kRejected:
        return polygon(MarkKind::kLines, outcome,
                       {corner(-1, -1), corner(1, 1), corner(-1, 1), corner(1, -1)});
      case Outcome::kInitialised:
        return polygon(MarkKind::kLoop, outcome,
                       {corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)});
      case Outcome::kWaiting:
        return polygon(MarkKind::kPoints, outcome, {at});
    }
  }

  void polygon(MarkKind kind, Outcome outcome, const Points& corners) {
    Json points = Json::array();
    for (const Eigen::Vector2d& p : corners) points.push_back(json_of(scale_ * p));
    points_.push_back({{"timestamp", proto_time(time_)},
                       {"type", static_cast<int>(kind)},
                       {"points", std::move(points)},
                       {"outline_color", proto_colour(outcome_colour(outcome), 1)},
                       {"thickness", kind == MarkKind::kPoints ? 2.0 : 1.0}});
  }

  Time time_;
  double scale_;
  Json circles_ = Json::array(), points_ = Json::array();
};

}  // namespace

std::vector<Eigen::Vector2d> ellipse_points(const ExpectedPixel& expected, double sigmas) {
  const SymmetricEigen eigen = symmetric_eigen(expected.covariance);
  Points points;
  if (!(eigen.values[0] > 0)) return points;
  const Eigen::Matrix2d L = eigen.vectors * eigen.values.cwiseSqrt().asDiagonal();
  for (int k = 0; k < kCorners; ++k) {
    const double angle = 2 * std::numbers::pi * k / kCorners;
    points.push_back(expected.pixel +
                     sigmas * L * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

Json image_message(const ShownImage& image) {
  if (image.jpeg.empty()) return nullptr;
  return {{"timestamp", proto_time(image.time)},
          {"frame_id", fmt::format("cam{}", image.camera)},
          {"data", Json::binary({image.jpeg.begin(), image.jpeg.end()})},
          {"format", "jpeg"}};
}

Json annotations_message(const ShownImage& image) {
  Annotations annotations(image.time, scale_of(image));
  for (const ImageFeature& feature : image.features) annotations.add(feature);
  return std::move(annotations).json();
}

void add_images(const std::vector<ShownImage>& images, Channels& out) {
  for (const ShownImage& image : images) {
    const Json picture = image_message(image);
    if (!picture.is_null()) out.add(image_topic(image.camera), image.time, picture);
    out.add(annotations_topic(image.camera), image.time, annotations_message(image));
  }
}

}  // namespace chasles
