#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <chasles/base/settings.hpp>
#include <chasles/camera/lens_coefficients.hpp>

namespace chasles {

/// The lens models, in the order of kLensModels. Saved maps hold these numbers: a new one is last.
enum class Distortion {
  kNone,
  kRadtan,
  kEquidistant,
  kDoubleSphere,
  kEucm,
  kOmni,
  kFov,
  kDivision,
  kFisheye624,
};

/// The image of a direction on the plane at unit focal length, and its derivative.
struct DistortedPoint {
  Eigen::Vector2d xy;    ///< (u - cx) / fx, (v - cy) / fy
  Eigen::Matrix2d d_xy;  ///< d xy / d (x/z, y/z)
};

/// The image of a unit vector on the same plane, and its derivative by a point at that vector. The
/// length of the point has no effect: d_bearing times the vector is zero.
struct DistortedBearing {
  Eigen::Vector2d xy;
  Eigen::Matrix<double, 2, 3> d_bearing;
};

/// Derivatives of a point of the plane by the coefficients of the lens model, in their order.
using LensDerivative =
    Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, static_cast<int>(LensCoefficients::kMost)>;

/// A lens model: how it distorts a direction (x/z, y/z) in front of the camera, and where it sees
/// more than 90 degrees to each side, any direction.
///
/// Invariants (lens_model_test.cpp asserts them for each model of kLensModels):
///   1. undistort(distort(xy)) = xy to 1e-12, relative to 1 + |xy|
///   2. d_xy is the derivative of distort
///   3. the axis stays: distort(0) = 0, with the derivative axis_slope times the identity
///   4. along a ray from the axis, distort is none from the first fold on
///   5. what is not finite, or where no direction leads, is none
///   6. distort_bearing is distort in front of the camera, and goes on smoothly beyond 90 degrees
///   7. bearing_of(distort_bearing(b)) = b to 1e-12; d_bearing is its derivative
///   8. straight behind, and from the first fold on, distort_bearing is none
///   9. by_coefficients is the derivative of distort and of distort_bearing
struct LensModel {
  using Coefficients = LensCoefficients;

  Distortion distortion;
  std::string_view name;          ///< in settings, messages and the files of Chasles
  std::string_view title;         ///< of the documentation
  std::string_view coefficients;  ///< names in order; "[" begins what shorter lists lack
  /// The numbers of coefficients that it may have; 0: no further one.
  std::array<std::uint8_t, 4> counts;
  std::string_view other_names;  ///< of other programs, in small letters, with spaces between
  std::string_view limits;       ///< of the coefficients, for messages; empty: any finite number

  /// None if the map folds over between the axis and the direction: it rises again beyond a fold,
  /// and a second direction would map to the same pixel.
  std::optional<DistortedPoint> (*distort)(const Coefficients& k, const Eigen::Vector2d& xy);
  /// The direction that distort maps to a finite `xy`, to round-off; none if no direction in front
  /// of the camera does.
  std::optional<Eigen::Vector2d> (*undistort)(const Coefficients& k, const Eigen::Vector2d& xy);
  /// Whether finite coefficients are within the limits. Null without limits.
  bool (*is_within)(const Coefficients& k);
  /// The slope of distort at the axis. Null where it is 1.
  double (*axis_slope)(const Coefficients& k);

  /// The same map for a unit vector of any direction. Null for models that end before 90 degrees;
  /// so is bearing_of.
  std::optional<DistortedBearing> (*distort_bearing)(const Coefficients& k,
                                                     const Eigen::Vector3d& bearing);
  /// The unit vector that distort_bearing maps to a finite `xy`, to round-off; none if none does.
  std::optional<Eigen::Vector3d> (*bearing_of)(const Coefficients& k, const Eigen::Vector2d& xy);
  /// At a unit vector that the model maps.
  LensDerivative (*by_coefficients)(const Coefficients& k, const Eigen::Vector3d& bearing);
};

// The functions of the models, one .cpp each. r = |(x/z, y/z)|, and theta = atan r. Functions of a
// bearing have the same formulas, with both sides of a fraction times z, and theta to 180 degrees.
namespace lens {

using OptionalPoint = std::optional<DistortedPoint>;
using OptionalXy = std::optional<Eigen::Vector2d>;
using OptionalImage = std::optional<DistortedBearing>;
using OptionalBearing = std::optional<Eigen::Vector3d>;

/// The identity: a pinhole camera.
OptionalPoint distort_none(const LensCoefficients& k, const Eigen::Vector2d& xy);
OptionalXy undistort_none(const LensCoefficients& k, const Eigen::Vector2d& xy);
LensDerivative by_coefficients_none(const LensCoefficients& k, const Eigen::Vector3d& bearing);

/// x r_d / r + [2 p1 x y + p2 (r^2 + 2 x^2) + s1 r^2 + s2 r^4,
///              p1 (r^2 + 2 y^2) + 2 p2 x y + s3 r^2 + s4 r^4],
/// r_d = r (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)
/// (Brown 1966, as OpenCV's calib3d, also with its rational and thin prism terms).
OptionalPoint distort_radtan(const LensCoefficients& k, const Eigen::Vector2d& xy);
OptionalXy undistort_radtan(const LensCoefficients& k, const Eigen::Vector2d& xy);
LensDerivative by_coefficients_radtan(const LensCoefficients& k, const Eigen::Vector3d& bearing);

/// x theta_d / r,  theta_d = theta (1 + k1 theta^2 + ... + k4 theta^8)
/// (Kannala & Brandt 2006, as OpenCV fisheye).
OptionalPoint distort_equidistant(const LensCoefficients& k, const Eigen::Vector2d& xy);
OptionalXy undistort_equidistant(const LensCoefficients& k, const Eigen::Vector2d& xy);
OptionalImage distort_bearing_equidistant(const LensCoefficients& k,
                                          const Eigen::Vector3d& bearing);
OptionalBearing bearing_of_equidistant(const LensCoefficients& k, const Eigen::Vector2d& xy);
LensDerivative by_coefficients_equidistant(const LensCoefficients& k,
                                           const Eigen::Vector3d& bearing);

/// x / (alpha sqrt(x^2 + y^2 + w^2) + (1 - alpha) w),  w = 1 + xi sqrt(1 + r^2)
/// (Usenko, Demmel & Cremers 2018, eq. 40 to 46).
OptionalPoint distort_double_sphere(const LensCoefficients& k, const Eigen::Vector2d& xy);
OptionalXy undistort_double_sphere(const LensCoefficients& k, const Eigen::Vector2d& xy);
OptionalImage distort_bearing_double_sphere(const LensCoefficients& k,
                                            const Eigen::Vector3d& bearing);
OptionalBearing bearing_of_double_sphere(const LensCoefficients& k, const Eigen::Vector2d& xy);
LensDerivative by_coefficients_double_sphere(const LensCoefficients& k,
                                             const Eigen::Vector3d& bearing);
bool double_sphere_within(const LensCoefficients& k);
double double_sphere_slope(const LensCoefficients& k);

/// x / (alpha sqrt(beta r^2 + 1) + 1 - alpha)  (Khomutenko, Garcia & Martinet 2016).
OptionalPoint distort_eucm(const LensCoefficients& k, const Eigen::Vector2d& xy);
OptionalXy undistort_eucm(const LensCoefficients& k, const Eigen::Vector2d& xy);
OptionalImage distort_bearing_eucm(const LensCoefficients& k, const Eigen::Vector3d& bearing);
OptionalBearing bearing_of_eucm(const LensCoefficients& k, const Eigen::Vector2d& xy);
LensDerivative by_coefficients_eucm(const LensCoefficients& k, const Eigen::Vector3d& bearing);
bool eucm_within(const LensCoefficients& k);

/// x / (1 + xi sqrt(1 + r^2)), and then radtan with k1, k2, p1, p2  (Mei & Rives 2007).
OptionalPoint distort_omni(const LensCoefficients& k, const Eigen::Vector2d& xy);
OptionalXy undistort_omni(const LensCoefficients& k, const Eigen::Vector2d& xy);
OptionalImage distort_bearing_omni(const LensCoefficients& k, const Eigen::Vector3d& bearing);
OptionalBearing bearing_of_omni(const LensCoefficients& k, const Eigen::Vector2d& xy);
LensDerivative by_coefficients_omni(const LensCoefficients& k, const Eigen::Vector3d& bearing);
bool omni_within(const LensCoefficients& k);
double omni_slope(const LensCoefficients& k);

/// x r_d / r,  r_d = atan(2 r tan(w / 2)) / w  (Devernay & Faugeras 2001).
OptionalPoint distort_fov(const LensCoefficients& k, const Eigen::Vector2d& xy);
OptionalXy undistort_fov(const LensCoefficients& k, const Eigen::Vector2d& xy);
OptionalImage distort_bearing_fov(const LensCoefficients& k, const Eigen::Vector3d& bearing);
OptionalBearing bearing_of_fov(const LensCoefficients& k, const Eigen::Vector2d& xy);
LensDerivative by_coefficients_fov(const LensCoefficients& k, const Eigen::Vector3d& bearing);
bool fov_within(const LensCoefficients& k);
double fov_slope(const LensCoefficients& k);

/// x r_d / r,  r = r_d / (1 + lambda r_d^2)  (Fitzgibbon 2001).
OptionalPoint distort_division(const LensCoefficients& k, const Eigen::Vector2d& xy);
OptionalXy undistort_division(const LensCoefficients& k, const Eigen::Vector2d& xy);
OptionalImage distort_bearing_division(const LensCoefficients& k, const Eigen::Vector3d& bearing);
OptionalBearing bearing_of_division(const LensCoefficients& k, const Eigen::Vector2d& xy);
LensDerivative by_coefficients_division(const LensCoefficients& k, const Eigen::Vector3d& bearing);

/// q = x theta_d / r,  theta_d = theta (1 + k0 theta^2 + ... + k5 theta^12), then
/// q + [p0 (|q|^2 + 2 qx^2) + 2 p1 qx qy + s0 |q|^2 + s1 |q|^4,
///      2 p0 qx qy + p1 (|q|^2 + 2 qy^2) + s2 |q|^2 + s3 |q|^4]
/// (Project Aria's FISHEYE624, COLMAP's RAD_TAN_THIN_PRISM_FISHEYE).
OptionalPoint distort_fisheye624(const LensCoefficients& k, const Eigen::Vector2d& xy);
OptionalXy undistort_fisheye624(const LensCoefficients& k, const Eigen::Vector2d& xy);
OptionalImage distort_bearing_fisheye624(const LensCoefficients& k, const Eigen::Vector3d& bearing);
OptionalBearing bearing_of_fisheye624(const LensCoefficients& k, const Eigen::Vector2d& xy);
LensDerivative by_coefficients_fisheye624(const LensCoefficients& k,
                                          const Eigen::Vector3d& bearing);

}  // namespace lens

/// All lens models. This list feeds the settings, the readers, messages, the help, the Python
/// package, saved maps, the documentation's table and the tests.
inline constexpr std::array kLensModels{
    LensModel{Distortion::kNone,
              "none",
              "none",
              "",
              {},
              "",
              "",
              &lens::distort_none,
              &lens::undistort_none,
              nullptr,
              nullptr,
              nullptr,
              nullptr,
              &lens::by_coefficients_none},
    LensModel{Distortion::kRadtan,
              "radtan",
              "radial-tangential (Brown-Conrady)",
              "k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4",
              {4, 5, 8, 12},
              "radial-tangential radial_tangential plumb_bob rational_polynomial",
              "",
              &lens::distort_radtan,
              &lens::undistort_radtan,
              nullptr,
              nullptr,
              nullptr,
              nullptr,
              &lens::by_coefficients_radtan},
    LensModel{Distortion::kEquidistant,
              "equidistant",
              "equidistant (Kannala-Brandt)",
              "k1 k2 k3 k4",
              {4},
              "equi fisheye",
              "",
              &lens::distort_equidistant,
              &lens::undistort_equidistant,
              nullptr,
              nullptr,
              &lens::distort_bearing_equidistant,
              &lens::bearing_of_equidistant,
              &lens::by_coefficients_equidistant},
    LensModel{Distortion::kDoubleSphere,
              "ds",
              "double sphere",
              "xi alpha",
              {2},
              "double_sphere",
              "xi above -1 and alpha from 0 to 1",
              &lens::distort_double_sphere,
              &lens::undistort_double_sphere,
              &lens::double_sphere_within,
              &lens::double_sphere_slope,
              &lens::distort_bearing_double_sphere,
              &lens::bearing_of_double_sphere,
              &lens::by_coefficients_double_sphere},
    LensModel{Distortion::kEucm,
              "eucm",
              "extended unified",
              "alpha beta",
              {2},
              "",
              "alpha from 0 to 1 and beta above 0",
              &lens::distort_eucm,
              &lens::undistort_eucm,
              &lens::eucm_within,
              nullptr,
              &lens::distort_bearing_eucm,
              &lens::bearing_of_eucm,
              &lens::by_coefficients_eucm},
    LensModel{Distortion::kOmni,
              "omni",
              "unified omnidirectional (Mei)",
              "xi [k1 k2 p1 p2",
              {1, 5},
              "mei",
              "xi above -1",
              &lens::distort_omni,
              &lens::undistort_omni,
              &lens::omni_within,
              &lens::omni_slope,
              &lens::distort_bearing_omni,
              &lens::bearing_of_omni,
              &lens::by_coefficients_omni},
    LensModel{Distortion::kFov,
              "fov",
              "field of view",
              "w",
              {1},
              "",
              "w above 0 and below pi",
              &lens::distort_fov,
              &lens::undistort_fov,
              &lens::fov_within,
              &lens::fov_slope,
              &lens::distort_bearing_fov,
              &lens::bearing_of_fov,
              &lens::by_coefficients_fov},
    LensModel{Distortion::kDivision,
              "division",
              "division",
              "lambda",
              {1},
              "",
              "",
              &lens::distort_division,
              &lens::undistort_division,
              nullptr,
              nullptr,
              &lens::distort_bearing_division,
              &lens::bearing_of_division,
              &lens::by_coefficients_division},
    LensModel{Distortion::kFisheye624,
              "fisheye624",
              "Aria's fisheye",
              "k0 k1 k2 k3 k4 k5 p0 p1 s0 s1 s2 s3",
              {12},
              "rad_tan_thin_prism_fisheye",
              "",
              &lens::distort_fisheye624,
              &lens::undistort_fisheye624,
              nullptr,
              nullptr,
              &lens::distort_bearing_fisheye624,
              &lens::bearing_of_fisheye624,
              &lens::by_coefficients_fisheye624},
};

template <>
struct Choices<Distortion> {
  static constexpr auto list = [] {
    std::array<Choice<Distortion>, kLensModels.size()> all{};
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i] = {kLensModels[i].distortion, kLensModels[i].name};
    }
    return all;
  }();
};

/// The model in the list; null for a number that is none of the enum's.
const LensModel* find_lens_model(Distortion distortion);

/// The model of one of its names, in small or capital letters; none for another.
std::optional<Distortion> lens_model_named(std::string_view name);

/// The models with their other names, for messages: "none, radtan (also ...), ...".
std::string lens_model_names();

/// The names of a model's coefficients, in order.
std::vector<std::string> coefficient_names(Distortion distortion);

/// The models with their coefficients: "none, radtan (k1 k2 p1 p2 [k3 ...), ...".
std::string lens_model_coefficients();

/// The list without zeros at its end, if the model may have so few coefficients. OpenCV and ROS
/// write zeros for terms that a calibration does not have.
std::span<const double> without_padding(Distortion distortion, std::span<const double> list);

/// What is wrong with a list of coefficients, to follow the place where it was found: "has 3
/// coefficients, expected 4, 5, 8 or 12 of radtan (k1 k2 ...)". Empty if nothing is.
std::string coefficients_fault(Distortion distortion, std::span<const double> list);

}  // namespace chasles
