#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include <chasles/check/check_rotation.hpp>

namespace chasles {

/// A quantity and its standard deviation.
struct Measured {
  double value = 0, sigma = 0;

  /// Whether it differs from `expected` by more than `limit` and by more than five sigmas.
  bool differs(double expected, double limit) const;
};

/// The errors of a lens and of its readout that explain the epipolar residuals of the tracks. A ray
/// of which the stated lens says that it is at the angle a [rad] from the optical axis is at
/// a + focal stretch + radial a^3 (TwoRays::first_stretch).
struct LensFit {
  Measured focal;    ///< relative error of the focal length [1]
  Measured radial;   ///< error of the distortion [1/rad^2]
  Measured readout;  ///< of a rolling shutter, from the first row to the last [s]
  Measured gain;     ///< images' rate over the gyroscope's [1]
  Measured offset;   ///< camera time + offset = gyroscope time, of the middle row [s]
  double edge = 0;   ///< 95 % of the rays are within this angle from the axis [rad]
  std::size_t intervals = 0;
  Eigen::Matrix3d cam_R_imu = Eigen::Matrix3d::Identity();
  Eigen::Vector3d bias_cam = Eigen::Vector3d::Zero();  ///< as in GyroscopeFit [rad/s]
  double cost = 0;  ///< robust mean over the rays: the lower of two fits to the same pairs is right

  /// The relative error of an angle at the edge that the distortion alone makes: radial edge^2.
  Measured radial_at_edge() const;
  /// Whether the distortion is another one: the error at the edge is above kMostAtEdge. A focal
  /// length that is wrong by more than kMostFocal leaves the distortion open.
  bool has_wrong_distortion() const {
    return radial_at_edge().differs(0, kMostAtEdge) && std::abs(focal.value) < kMostFocal;
  }
  /// Whether the rows are exposed one after the other, over more than kLeastReadout.
  bool is_rolling() const { return readout.differs(0, kLeastReadout); }

  static constexpr double kMostAtEdge = 0.05;
  static constexpr double kMostFocal = 0.3;
  static constexpr double kLeastReadout = 0.006;  ///< [s]
};

/// The pairs with the errors of focal length and distortion undone.
std::vector<SeenTwice> mended(const std::vector<SeenTwice>& seen, const LensFit& lens);

/// The pairs as the middle row sees them: with the readout undone, by the rates of the gyroscope.
std::vector<SeenTwice> unrolled(const std::vector<SeenTwice>& seen,
                                const std::vector<StampedRate>& gyroscope, const LensFit& lens);

/// Fits lens, readout, and the parameters of GyroscopeFit to pairs of frames, by robust least
/// squares of the angles between rays and their epipolar planes. The gyroscope, from `start` on,
/// determines the rotation of each pair to 1.5 mrad; the direction of the translation is free.
/// Standard deviations treat seconds as independent. Returns nothing for a mirrored fit, a gain
/// outside of 0.3 to 3, fewer than 20 pairs of frames, a focal length beyond a factor of three, or
/// without convergence.
std::optional<LensFit> fit_lens(const std::vector<SeenTwice>& seen,
                                const std::vector<StampedRate>& gyroscope,
                                const GyroscopeFit& start);

}  // namespace chasles
