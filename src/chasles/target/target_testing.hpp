#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/numeric/random.hpp>
#include <chasles/target/tag_layout.hpp>
#include <chasles/target/target.hpp>

namespace chasles::test {

/// How a target is photographed.
struct Photograph {
  double blur = 0.5;               ///< standard deviation of a Gaussian [px]
  Eigen::Vector2d motion{0, 0};    ///< of the image during the exposure, blurs along it [px]
  double noise = 2;                ///< standard deviation [grey values]
  double black = 25, white = 210;  ///< grey values of the print
  Eigen::Vector2d light{0, 0};     ///< part by which the light grows across the image
  bool clutter = true;             ///< a bright and dark pattern behind the board
  double cover = 0;                ///< part of the board's width that a hand covers
  std::uint64_t seed = 1;
};

/// Images of a target through a lens, and where its corners are in them. The print is sharp: each
/// pixel is the mean of 4 x 4 points.
class TargetRenderer {
 public:
  TargetRenderer(Target target, Camera camera)
      : target_(std::move(target)),
        camera_(std::move(camera)),
        tags_(printed_tags(target_)),
        outline_(board_outline(target_)) {
    for (int y = 0; y <= camera_.height; ++y) {
      for (int x = 0; x <= camera_.width; ++x) {
        const auto direction = bearing(camera_, Eigen::Vector2d(x - 0.5, y - 0.5));
        bearings_.push_back(direction ? direction->bearing : Eigen::Vector3d::Zero());
      }
    }
  }

  /// cam_T_target maps the target's frame to that of the camera.
  GrayImage render(const SE3& cam_T_target, const Photograph& how) const {
    return render([&](double) { return cam_T_target; }, how);
  }

  /// By a rolling shutter: the pose at the time of a row, which may lie between two.
  GrayImage render(const std::function<SE3(double row)>& cam_T_target_at,
                   const Photograph& how) const {
    const std::vector<Place> places = places_of(cam_T_target_at);
    std::vector<double> grey(static_cast<std::size_t>(camera_.width) * camera_.height);
    for (int y = 0; y < camera_.height; ++y) {
      for (int x = 0; x < camera_.width; ++x) grey[index(x, y)] = mean_grey(places, x, y, how);
    }
    blur(grey, how.blur);
    smear(grey, how.motion);
    const Random random{how.seed};
    GrayImage image{camera_.width, camera_.height, {}};
    for (std::size_t i = 0; i < grey.size(); ++i) {
      const Eigen::Vector2d at(
          static_cast<double>(i % static_cast<std::size_t>(camera_.width)) / camera_.width - 0.5,
          static_cast<double>(i / static_cast<std::size_t>(camera_.width)) / camera_.height - 0.5);
      const double value = grey[i] * (1 + how.light.dot(at)) +
                           (how.noise > 0 ? how.noise * random.normal(Stream::kImageNoise, i) : 0);
      image.pixels.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L)));
    }
    return image;
  }

  /// Pixels of all corners; none where the lens has no pixel or the board shows its back. They may
  /// lie outside the image.
  std::vector<std::optional<Eigen::Vector2d>> corners(const SE3& cam_T_target) const {
    std::vector<std::optional<Eigen::Vector2d>> result;
    for (const Eigen::Vector3d& p : target_.corners()) {
      const Eigen::Vector3d p_cam = cam_T_target * p;
      const auto projection = project(camera_, p_cam);
      const bool front = cam_T_target.R.col(2).dot(p_cam) < 0;
      result.push_back(projection && front ? std::optional(projection->pixel) : std::nullopt);
    }
    return result;
  }

  /// Whether the print is black there [m]. Independent of black_rectangles().
  bool is_black(const Eigen::Vector2d& p) const {
    const Eigen::Array2d low = outline_.lower_left, high = outline_.upper_right;
    if ((p.array() < low).any() || (p.array() >= high).any()) return false;
    if (target_.kind == TargetKind::april_grid) return is_black_of_april_grid(p);
    const Eigen::Array2d square(target_.column_spacing, target_.row_spacing);
    const Eigen::Array2i at = ((p.array() - low) / square).floor().cast<int>();
    if (is_black_square(target_, at.x(), at.y())) return true;
    if (target_.kind == TargetKind::checkerboard) return false;
    for (const PrintedTag& tag : tags_) {
      if (tag.grid.x() + 1 == at.x() && tag.grid.y() + 1 == at.y()) return is_black_of(tag, p);
    }
    return false;
  }

  const Target& target() const { return target_; }
  const Camera& camera() const { return camera_; }

 private:
  struct Place {
    Eigen::Vector2d on_board{0, 0};
    bool valid = false;
  };

  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * camera_.width + x; }

  // Where the corners of the pixels are on the board.
  std::vector<Place> places_of(const std::function<SE3(double row)>& cam_T_target_at) const {
    std::vector<Place> result;
    result.reserve(bearings_.size());
    for (int y = 0; y <= camera_.height; ++y) {
      const SE3 cam_T_target = cam_T_target_at(y - 0.5);
      const Eigen::Vector3d normal = cam_T_target.R.col(2);
      const double distance = normal.dot(cam_T_target.p);
      for (int x = 0; x <= camera_.width; ++x) {
        const Eigen::Vector3d& b = bearings_[result.size()];
        const double scale = distance / normal.dot(b);
        if (distance >= 0 || !(scale > 0)) {
          result.push_back({});
          continue;
        }
        const Eigen::Vector3d p = cam_T_target.R.transpose() * (scale * b - cam_T_target.p);
        result.push_back({p.head<2>(), true});
      }
    }
    return result;
  }

  double mean_grey(const std::vector<Place>& places, int x, int y, const Photograph& how) const {
    constexpr int kSide = 4;
    const std::size_t a = static_cast<std::size_t>(y) * (camera_.width + 1) + x, b = a + 1;
    const std::size_t c = a + camera_.width + 1, d = c + 1;
    for (const std::size_t i : {a, b, c, d}) {
      if (!places[i].valid) return 90;
    }
    double sum = 0;
    for (int j = 0; j < kSide; ++j) {
      const double v = (j + 0.5) / kSide;
      const Eigen::Vector2d left = (1 - v) * places[a].on_board + v * places[c].on_board;
      const Eigen::Vector2d right = (1 - v) * places[b].on_board + v * places[d].on_board;
      for (int i = 0; i < kSide; ++i) {
        const double u = (i + 0.5) / kSide;
        sum += grey_at((1 - u) * left + u * right, how);
      }
    }
    return sum / (kSide * kSide);
  }

  double grey_at(const Eigen::Vector2d& p, const Photograph& how) const {
    const Eigen::Vector2d size = outline_.upper_right - outline_.lower_left;
    const Eigen::Vector2d margin = Eigen::Vector2d::Constant(0.05 * size.minCoeff());
    const bool paper = (p.array() > (outline_.lower_left - margin).array()).all() &&
                       (p.array() < (outline_.upper_right + margin).array()).all();
    if (how.cover > 0 && covers(p, how.cover)) return 120;
    if (paper) return is_black(p) ? how.black : how.white;
    if (!how.clutter) return 120;
    const Eigen::Array2d cell = (p.array() / (0.045 * size.minCoeff())).floor();
    if (cell.abs().maxCoeff() > 1e6) return 90;
    const auto number = static_cast<std::uint64_t>((cell.x() + 2e6) * 4e6 + cell.y() + 2e6);
    return 20 + 210 * Random{how.seed}.uniform(Stream::kTexture, number);
  }

  // A disc at the middle of the right side.
  bool covers(const Eigen::Vector2d& p, double part) const {
    const Eigen::Vector2d size = outline_.upper_right - outline_.lower_left;
    const Eigen::Vector2d middle(outline_.upper_right.x(),
                                 outline_.lower_left.y() + 0.4 * size.y());
    return (p - middle).norm() < part * size.x();
  }

  bool is_black_of_april_grid(const Eigen::Vector2d& p) const {
    const double gap = target_.tag_size * target_.tag_spacing, step = target_.tag_size + gap;
    const Eigen::Array2i at = ((p.array() + gap) / step).floor().cast<int>();
    const Eigen::Array2d inside = p.array() - at.cast<double>() * step;
    if ((inside < 0).all()) return true;
    if ((inside < 0).any() || at.x() >= target_.columns || at.y() >= target_.rows) return false;
    return is_black_of(tags_[static_cast<std::size_t>(at.y() * target_.columns + at.x())], p);
  }

  bool is_black_of(const PrintedTag& tag, const Eigen::Vector2d& p) const {
    const TagCells cells = tag_cells(target_);
    const Eigen::Array2i at =
        ((p - tag.lower_left).array() / target_.tag_size * cells.side).floor().cast<int>();
    if ((at < 0).any() || (at >= cells.side).any()) return false;
    const int bits = cells.side - 2 * cells.border;
    const int column = at.x() - cells.border, row = cells.side - 1 - at.y() - cells.border;
    if (column < 0 || row < 0 || column >= bits || row >= bits) return true;
    return (tag.code >> (bits * bits - 1 - (row * bits + column)) & 1) == 0;
  }

  void blur(std::vector<double>& grey, double sigma) const {
    if (sigma <= 0) return;
    const int reach = static_cast<int>(std::ceil(4 * sigma));
    std::vector<double> kernel;
    double sum = 0;
    for (int k = -reach; k <= reach; ++k) {
      kernel.push_back(std::exp(-0.5 * k * k / (sigma * sigma)));
      sum += kernel.back();
    }
    for (double& weight : kernel) weight /= sum;
    convolve(grey, kernel, reach, 1, 0);
    convolve(grey, kernel, reach, 0, 1);
  }

  // The mean of images that move by so much about the middle of the exposure.
  void smear(std::vector<double>& grey, const Eigen::Vector2d& motion) const {
    const int steps = 2 * static_cast<int>(std::ceil(motion.norm())) + 1;
    if (steps == 1) return;
    const std::vector<double> before = grey;
    std::ranges::fill(grey, 0.0);
    for (int step = 0; step < steps; ++step) {
      const Eigen::Vector2d shift = ((step + 0.5) / steps - 0.5) * motion;
      for (int y = 0; y < camera_.height; ++y) {
        for (int x = 0; x < camera_.width; ++x) {
          grey[index(x, y)] += between(before, Eigen::Vector2d(x, y) + shift) / steps;
        }
      }
    }
  }

  // The value between pixels; outside, that of the nearest pixel.
  double between(const std::vector<double>& grey, const Eigen::Vector2d& at) const {
    const double x = std::clamp(at.x(), 0.0, camera_.width - 1.001);
    const double y = std::clamp(at.y(), 0.0, camera_.height - 1.001);
    const int left = static_cast<int>(x), top = static_cast<int>(y);
    const double u = x - left, v = y - top;
    return (1 - v) * ((1 - u) * grey[index(left, top)] + u * grey[index(left + 1, top)]) +
           v * ((1 - u) * grey[index(left, top + 1)] + u * grey[index(left + 1, top + 1)]);
  }

  void convolve(std::vector<double>& grey, const std::vector<double>& kernel, int reach, int dx,
                int dy) const {
    const std::vector<double> before = grey;
    for (int y = 0; y < camera_.height; ++y) {
      for (int x = 0; x < camera_.width; ++x) {
        double value = 0;
        for (int k = -reach; k <= reach; ++k) {
          const int at_x = std::clamp(x + k * dx, 0, camera_.width - 1);
          const int at_y = std::clamp(y + k * dy, 0, camera_.height - 1);
          value += kernel[static_cast<std::size_t>(k + reach)] * before[index(at_x, at_y)];
        }
        grey[index(x, y)] = value;
      }
    }
  }

  Target target_;
  Camera camera_;
  std::vector<PrintedTag> tags_;
  PrintedRectangle outline_;
  std::vector<Eigen::Vector3d> bearings_;  // of the corners of the pixels; zero where there is none
};

/// A pose that looks at the middle of the board: `distance` [m] away, the board's normal `tilt`
/// from the line of sight towards `towards`, the camera turned by `roll`, and the middle of the
/// board `aside` from the axis in that direction of the image (all angles [rad]).
struct Viewpoint {
  double distance = 1, tilt = 0, towards = 0, roll = 0, aside = 0, aside_towards = 0;
};

inline SE3 cam_T_target_of(const Target& target, const Viewpoint& from) {
  const auto turn = [](double angle, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  };
  const Eigen::Matrix3d front = Eigen::Vector3d(1, -1, -1).asDiagonal();
  const Eigen::Vector3d tilt_axis(std::cos(from.towards), std::sin(from.towards), 0);
  const Eigen::Vector3d away(std::cos(from.aside_towards), std::sin(from.aside_towards), 0);
  const Eigen::Matrix3d to_aside = turn(from.aside, Eigen::Vector3d::UnitZ().cross(away));
  const PrintedRectangle outline = board_outline(target);
  const Eigen::Vector2d middle = (outline.lower_left + outline.upper_right) / 2;
  SE3 result;
  result.R =
      to_aside * turn(from.tilt, tilt_axis) * turn(from.roll, Eigen::Vector3d::UnitZ()) * front;
  result.p = to_aside * Eigen::Vector3d(0, 0, from.distance) -
             result.R * Eigen::Vector3d(middle.x(), middle.y(), 0);
  return result;
}

}  // namespace chasles::test
