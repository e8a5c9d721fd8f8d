#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/check/lens_guess.hpp>

namespace chasles {
namespace {

constexpr double kMostOffMiddle = 0.2;    // of a guessed principal point, over the image
constexpr double kLeastOffMiddle = 0.04;  // nearer, the middle explains nothing
constexpr double kUnequal = 0.03;         // of the focal lengths

constexpr double kOtherFocal = 0.06;  // of a focal length
constexpr double kOtherAngle = 0.05;  // of an angle at the edge

std::string model(const Camera& c) {
  if (c.distortion == Distortion::kNone) return "none";
  return fmt::format("{} [{:.4g}]", name_of(c.distortion), fmt::join(c.coefficients, ", "));
}

// The angle from the axis of the pixel in the middle of the right edge; none beyond the lens.
std::optional<double> edge_angle(const Camera& c, const Eigen::Vector2d& pixel) {
  const auto ray = wide_ray(c, pixel);
  if (!ray) return std::nullopt;
  return std::atan2(ray->ray.head<2>().norm(), ray->ray.z());
}

// Of the stated lens, relative to the guessed one [1].
double angle_error(const Camera& stated, const Camera& guessed) {
  const Eigen::Vector2d pixel(stated.width > 0 ? stated.width - 1 : 2 * stated.cx, stated.cy);
  const auto a = edge_angle(stated, pixel), b = edge_angle(guessed, pixel);
  return a && b ? *a / *b - 1 : 1;
}

Eigen::Vector2d middle(const Camera& c) { return {(c.width - 1) / 2.0, (c.height - 1) / 2.0}; }

// The distance of the principal point from the middle, over the size of the image.
double off_middle(const Camera& c) {
  const Eigen::Vector2d off(c.cx - middle(c).x(), c.cy - middle(c).y());
  return off.cwiseQuotient(Eigen::Vector2d(c.width, c.height)).cwiseAbs().maxCoeff();
}

bool has_size(const Camera& c) { return c.width > 0 && c.height > 0; }

// The sizes of images that are not those of the calibration scale the focal length by these.
std::string size_advice(double size) {
  for (const double whole : {2.0, 0.5, 3.0, 1 / 3.0, 4.0, 0.25}) {
    if (std::abs(size / whole - 1) > 0.06) continue;
    return fmt::format(
        "the images seem to have {:.3g} times the size for which the lens was calibrated: scale "
        "fx, fy, cx and cy with them",
        whole);
  }
  return "calibrate the camera again, or scale fx, fy, cx and cy with the size of the images";
}

void add_centres(const Camera& stated, std::vector<LensGuess>& guesses) {
  if (!has_size(stated)) return;
  const auto add = [&](const Eigen::Vector2d& centre, const char* name, const char* advice) {
    const Eigen::Vector2d off = centre - Eigen::Vector2d(stated.cx, stated.cy);
    guesses.push_back(
        {.camera = stated,
         .what = fmt::format("its principal point is not the stated one: ({:.1f}, {:.1f}){} fits, "
                             "and ({:.1f}, {:.1f}) is stated",
                             centre.x(), centre.y(), name, stated.cx, stated.cy),
         .advice = advice,
         .value = off.norm(),
         .threshold = kLeastOffMiddle * stated.width,
         .unit = "px"});
    guesses.back().camera.cx = centre.x();
    guesses.back().camera.cy = centre.y();
  };
  Camera exchanged = stated;
  std::swap(exchanged.cx, exchanged.cy);
  if (stated.cx != stated.cy && off_middle(exchanged) < kMostOffMiddle) {
    add({stated.cy, stated.cx}, "",
        "cx and cy seem to be exchanged: intrinsics are fx, fy, cx, cy");
  }
  if (off_middle(stated) > kLeastOffMiddle) {
    add(middle(stated), ", the middle of the images,",
        "check cx and cy, and move them where the images were cut");
  }
}

void add_focal_lengths(const Camera& stated, std::vector<LensGuess>& guesses) {
  const double unequal = std::abs(stated.fx / stated.fy - 1);
  if (unequal < kUnequal) return;
  for (const double focal : {stated.fx, stated.fy}) {
    guesses.push_back({.camera = stated,
                       .what = fmt::format("its focal lengths are not the stated ones: {:.1f} px "
                                           "fit for both, and fx {:.1f} and fy {:.1f} are stated",
                                           focal, stated.fx, stated.fy),
                       .advice = "pixels are square in most cameras: check fx and fy, and how the "
                                 "images were scaled",
                       .value = 100 * unequal,
                       .threshold = 100 * kUnequal,
                       .unit = "%"});
    guesses.back().camera.fx = guesses.back().camera.fy = focal;
  }
}

void add_distortion(const Camera& stated, Distortion distortion,
                    const LensCoefficients& coefficients, const char* advice,
                    std::vector<LensGuess>& guesses) {
  if (distortion == stated.distortion && coefficients == stated.coefficients) return;
  LensGuess guess{.camera = stated, .advice = advice};
  Camera& c = guess.camera;
  c.distortion = distortion;
  c.coefficients = coefficients;
  const double error = angle_error(stated, c);
  if (std::abs(error) < kOtherAngle) return;
  guess.what = fmt::format("its lens is not the stated one: {} fits, and {} is stated", model(c),
                           model(stated));
  guess.value = 100 * std::abs(error);
  guess.threshold = 100 * kOtherAngle;
  guess.unit = std::string(1, '%');  // no literal: g++ 12 warns of an overlap
  guesses.push_back(guess);
}

// The stated coefficients with others in place of the first ones.
LensCoefficients with_first(const Camera& stated, const std::array<double, 4>& first) {
  LensCoefficients changed = stated.coefficients;
  for (std::size_t i = 0; i < std::min(first.size(), changed.size()); ++i) changed[i] = first[i];
  return changed;
}

// The mistakes of the models whose plane is that of a pinhole; the focal lengths of the others
// belong to their coefficients.
void add_distortions(const Camera& stated, std::vector<LensGuess>& guesses) {
  const LensCoefficients& k = stated.coefficients;
  const bool radtan = stated.distortion == Distortion::kRadtan;
  if ((!radtan && stated.distortion != Distortion::kEquidistant) || k.is_zero()) return;
  const auto add = [&](Distortion distortion, const LensCoefficients& changed, const char* advice) {
    add_distortion(stated, distortion, changed, advice, guesses);
  };
  if (radtan) {
    const char* const order = "its coefficients are in another order: radtan has k1, k2, p1, p2";
    add(stated.distortion, with_first(stated, {k[2], k[3], k[0], k[1]}), order);
    add(stated.distortion, with_first(stated, {k[1], k[0], k[2], k[3]}), order);
  }
  const char* const sign = "its coefficients have the wrong sign";
  add(stated.distortion, with_first(stated, {-k[0], k[1], k[2], k[3]}), sign);
  add(stated.distortion, with_first(stated, {-k[0], -k[1], -k[2], -k[3]}), sign);
  add(radtan ? Distortion::kEquidistant : Distortion::kRadtan, {k[0], k[1], k[2], k[3]},
      "its coefficients are those of the other model");
  add(Distortion::kNone, {}, "the images have no distortion: are they undistorted already?");
}

}  // namespace

std::optional<double> size_of_images(const Camera& stated) {
  if (!has_size(stated)) return std::nullopt;
  const double size =
      (stated.width / (2 * stated.cx + 1) + stated.height / (2 * stated.cy + 1)) / 2;
  return std::abs(size - 1) > kMostOffMiddle ? std::optional(size) : std::nullopt;
}

std::optional<LensGuess> sized_guess(const Camera& stated, double size, bool moves_centre) {
  LensGuess guess{.camera = stated, .advice = size_advice(size)};
  Camera& c = guess.camera;
  c.fx *= size;
  c.fy *= size;
  guess.what =
      fmt::format("its focal length is not the stated one: {:.1f} px fit, and {:.1f} px are stated",
                  c.fx, stated.fx);
  guess.value = 100 * std::abs(1 / size - 1);
  guess.threshold = 100 * kOtherFocal;
  guess.unit = std::string(1, '%');  // no literal: g++ 12 warns of an overlap
  if (!moves_centre) return guess;
  c.cx = (stated.cx + 0.5) * size - 0.5;
  c.cy = (stated.cy + 0.5) * size - 0.5;
  if (!has_size(stated) || off_middle(c) > kMostOffMiddle) return std::nullopt;
  return guess;
}

std::vector<LensGuess> lens_guesses(const Camera& stated) {
  std::vector<LensGuess> guesses;
  add_centres(stated, guesses);
  add_focal_lengths(stated, guesses);
  add_distortions(stated, guesses);
  return guesses;
}

}  // namespace chasles
