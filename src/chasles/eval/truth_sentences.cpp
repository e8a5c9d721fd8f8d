#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/eval/truth_limits.hpp>
#include <chasles/eval/truth_sentences.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

// imu_T_truth as the four rows of a file.
std::string matrix_text(const SE3& pose) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    text += fmt::format("{:.6f} {:.6f} {:.6f} {:.4f}; ", pose.R(i, 0), pose.R(i, 1), pose.R(i, 2),
                        pose.p[i]);
  }
  return text + "0 0 0 1";
}

double degrees_per_second(const TurningExplanation& turning) { return kDegrees * turning.residual; }

std::string axis_name(const Eigen::Vector3d& up) {
  Eigen::Index axis = 0;
  up.cwiseAbs().maxCoeff(&axis);
  return fmt::format("{} axis points {}", "xyz"[axis], up[axis] > 0 ? "up" : "down");
}

}  // namespace

std::string_view name(TruthFault fault) {
  switch (fault) {
    case TruthFault::kPositionsOnly:
      return "positions_only";
    case TruthFault::kClock:
      return "clock";
    case TruthFault::kWFirst:
      return "w_first";
    case TruthFault::kConjugate:
      return "inverse_rotations";
    case TruthFault::kInverse:
      return "inverse_poses";
    case TruthFault::kFrame:
      return "frame";
    case TruthFault::kPoint:
      return "point";
    case TruthFault::kUnit:
      return "unit";
    case TruthFault::kMirrored:
      return "mirrored";
    case TruthFault::kTilted:
      return "tilted";
    case TruthFault::kSparse:
      return "sparse";
    case TruthFault::kInterpolated:
      return "interpolated";
    case TruthFault::kUnlikePath:
      return "unlike_path";
    case TruthFault::kUnlike:
      break;
  }
  return "unlike";
}

std::string sentence(const TruthFinding& finding) {
  return fmt::format("the truth: {}; {}", finding.what, finding.advice);
}

TruthFinding positions_only_finding(const TruthReference& reference, std::size_t poses,
                                    bool stated) {
  return {.fault = TruthFault::kPositionsOnly,
          .what = stated ? std::string("it has positions and no attitudes")
                         : fmt::format("its attitude is the same in all {} poses, while {} turns: "
                                       "it has positions alone",
                                       poses, reference.name),
          .value = static_cast<double>(poses),
          .unit = "poses",
          .advice =
              "errors and NEES of attitude and pose are left out, and so are relative errors "
              "and those after an alignment by the first pose"};
}

TruthFinding unlike_finding(const TruthReference& reference, double unexplained) {
  return {.fault = TruthFault::kUnlike,
          .what = fmt::format("its rotations do not follow those of {}: {:.0f} % of their rates is "
                              "left in the best reading",
                              reference.name, 100 * unexplained),
          .value = unexplained,
          .threshold = truth_limits::kUnlike,
          .unit = "",
          .advice =
              "expected the truth of this recording, by the same clock; or the gyroscope's "
              "axes or unit are wrong"};
}

TruthFinding unlike_attitudes_finding(const TruthReference& reference, const AttitudeFit& fit) {
  const double left = kDegrees * fit.rms;
  return {.fault = TruthFault::kUnlike,
          .what = fmt::format("its attitudes do not follow those of {}: {:.1f} deg are left after "
                              "the best rotations, of {:.1f} deg by which {} turns",
                              reference.name, left, kDegrees * fit.excursion, reference.name),
          .value = left,
          .threshold = kDegrees * unlike_attitudes_limit(fit),
          .unit = "deg",
          .advice =
              "expected the attitudes of this recording, by the same clock; those of one axis "
              "alone, as a heading, are none: write positions alone (t x y z)"};
}

TruthFinding w_first_finding(const TruthReference& reference, const TurningExplanation& turning) {
  return {.fault = TruthFault::kWFirst,
          .what = fmt::format("its quaternions are w, x, y, z, read as x, y, z, w: in that order{} "
                              "its rates agree with those of {} to {:.2f} deg/s",
                              is_inverse(turning.reading) ? ", and inverted," : "", reference.name,
                              degrees_per_second(turning)),
          .value = degrees_per_second(turning),
          .unit = "deg/s",
          .advice =
              "name the columns in the first line, `# t tx ty tz qw qx qy qz`, or write w "
              "last"};
}

TruthFinding inverse_finding(const TruthReference& reference, const TurningExplanation& turning,
                             bool whole) {
  std::string advice = "--truth-inverse takes the inverse of each pose";
  if (!whole && reference.positions) {
    advice = "write world_R_imu: qx, qy, qz with the other sign";
  } else if (!whole) {
    advice += ", if the positions are inverted too; else write qx, qy, qz with the other sign";
  }
  return {.fault = whole ? TruthFault::kInverse : TruthFault::kConjugate,
          .what = fmt::format("{}: so its rates agree with those of {} to {:.2f} deg/s",
                              whole ? "its poses are imu_T_world, the inverse of world_T_imu"
                                    : "its rotations are imu_R_world, the inverse of world_R_imu",
                              reference.name, degrees_per_second(turning)),
          .value = degrees_per_second(turning),
          .unit = "deg/s",
          .advice = advice};
}

TruthFinding sparse_finding(double spacing, double longest_gap) {
  return {
      .fault = TruthFault::kSparse,
      .what = fmt::format("its poses are {:.3g} s apart, and between stamps more than {:g} s apart "
                          "none is compared: only those near its stamps are",
                          spacing, longest_gap),
      .value = spacing,
      .threshold = longest_gap,
      .unit = "s",
      .advice = fmt::format("--max-truth-gap {:.2g} interpolates it, if the motion between is "
                            "slow",
                            1.5 * spacing)};
}

TruthFinding interpolated_finding(const InterpolationError& error, double spacing) {
  return {
      .fault = TruthFault::kInterpolated,
      .what = fmt::format("its poses are {:.3g} s apart: interpolation between them adds about "
                          "{:.2g} m and {:.2g} deg to the errors, by the motion of the estimate",
                          spacing, error.position, kDegrees * error.attitude),
      .value = error.position,
      .unit = "m",
      .advice =
          "errors and NEES contain that; --pairing nearest compares at its stamps alone, where "
          "they coincide with those of the estimate"};
}

TruthFinding clock_finding(const TruthReference& reference, const TruthClock& clock, double least,
                           const BeforeAndAfter& ate, const BeforeAndAfter& attitudes) {
  std::string effect;
  if (ate.before && ate.after) {
    effect = fmt::format("; the ATE is {:.4g} m, and {:.4g} m with its clock corrected",
                         *ate.before, *ate.after);
  } else if (ate.after) {
    effect = fmt::format("; with its clock corrected the ATE is {:.4g} m", *ate.after);
  }
  if (attitudes.before && attitudes.after) {
    effect += fmt::format("; the attitudes are off by {:.3g} deg, and by {:.3g} deg then",
                          kDegrees * *attitudes.before, kDegrees * *attitudes.after);
  }
  return {
      .fault = TruthFault::kClock,
      .what = fmt::format("its times are {:.4f} +- {:.1g} s {} by the {} of {}{}",
                          std::abs(clock.offset), clock.sigma, clock.offset > 0 ? "early" : "late",
                          clock.by_rotations ? "rotations" : "positions", reference.name, effect),
      .value = clock.offset,
      .sigma = clock.sigma,
      .threshold = std::max(least, truth_limits::kManySigmas * clock.sigma),
      .unit = "s",
      .advice = fmt::format("--truth-time-offset {:.4f} (or auto) corrects it", clock.offset)};
}

TruthFinding known_frame_finding(const TruthReference& reference, const BodyFrame& frame) {
  const std::string& name = frame.known->name;
  const double angle = kDegrees * so3::log(frame.known->imu_T_frame.R).norm();
  const std::string agrees =
      frame.residual
          ? fmt::format("its rates agree with those of {} to {:.2f} deg/s", reference.name,
                        kDegrees * *frame.residual)
          : fmt::format("its attitudes agree with those of {} in the world of the positions",
                        reference.name);
  return {.fault = TruthFault::kFrame,
          .what = fmt::format("its poses are those of {}, not of the IMU: with the extrinsics of "
                              "{} ({:.1f} deg) {}",
                              name, name, angle, agrees),
          .value = angle,
          .unit = "deg",
          .advice = fmt::format("--truth-frame {} moves it to the IMU", name)};
}

TruthFinding other_frame_finding(const TruthReference& reference, const BodyFrame& frame,
                                 const std::optional<PositionFit>& point) {
  const double angle = kDegrees * so3::log(frame.imu_R_truth).norm();
  const SE3 imu_T_truth{frame.imu_R_truth, point ? point->point : Eigen::Vector3d::Zero()};
  const std::string away =
      point ? fmt::format(", {:.3f} +- {:.3f} m away", point->point.norm(), point->point_sigma)
            : std::string();
  return {
      .fault = TruthFault::kFrame,
      .what = fmt::format("its poses are those of another frame than the IMU's, as of a marker: "
                          "turned by {:.2f} +- {:.2f} deg{}, by the {} of {}",
                          angle, kDegrees * frame.sigma, away,
                          frame.residual ? "rates" : "positions and attitudes", reference.name),
      .value = angle,
      .sigma = kDegrees * frame.sigma,
      .threshold = kDegrees * frame.threshold,
      .unit = "deg",
      .advice = fmt::format("--truth-frame FILE moves it to the IMU; FILE has imu_T_truth, best "
                            "by your calibration; as estimated: {}",
                            matrix_text(imu_T_truth))};
}

TruthFinding point_finding(const PositionFit& fit) {
  return {
      .fault = TruthFault::kPoint,
      .what = fmt::format("its positions are those of a point {:.3f} +- {:.3f} m from the IMU, "
                          "at ({:.3f}, {:.3f}, {:.3f}) in its axes: the ATE of that point is "
                          "{:.4g} m",
                          fit.point.norm(), fit.point_sigma, fit.point.x(), fit.point.y(),
                          fit.point.z(), fit.rms),
      .value = fit.point.norm(),
      .sigma = fit.point_sigma,
      .threshold =
          std::max(truth_limits::kLeastPoint, truth_limits::kPointSigmas * fit.point_sigma),
      .unit = "m",
      .advice = fmt::format("--truth-frame FILE moves it to the IMU; FILE has imu_T_truth, best "
                            "by your calibration; as estimated: {}",
                            matrix_text({Eigen::Matrix3d::Identity(), fit.point}))};
}

TruthFinding beside_frame_finding(const KnownFrame& frame, const PositionFit& point) {
  TruthFinding finding = point_finding(point);
  const SE3 imu_T_truth{frame.imu_T_frame.R, frame.imu_T_frame.p + point.point};
  finding.what = fmt::format("its positions are those of a point {:.3f} +- {:.3f} m from {}",
                             point.point.norm(), point.point_sigma, frame.name);
  finding.advice = fmt::format("--truth-frame FILE moves it to the IMU instead; as estimated: {}",
                               matrix_text(imu_T_truth));
  return finding;
}

TruthFinding unlike_path_finding(const PositionFit& fit) {
  return {.fault = TruthFault::kUnlikePath,
          .what = fmt::format("its positions are not those of the estimate's path: the best "
                              "similarity leaves {:.3g} of an extent of {:.3g}",
                              fit.rms, fit.extent),
          .value = fit.rms / fit.extent,
          .threshold = truth_limits::kUnlikePath,
          .unit = "",
          .advice =
              "expected the truth of this recording, by the same clock, with x, y and z in one "
              "unit; or the estimate has failed"};
}

TruthFinding degrees_finding(DegreesOrder order) {
  return {
      .fault = TruthFault::kUnlikePath,
      .what = fmt::format("its positions are {} in degrees and a height: in metres they are the "
                          "estimate's path",
                          order == DegreesOrder::kLatitudeFirst ? "latitude and longitude"
                                                                : "longitude and latitude"),
      .advice = "convert them to metres in a local frame: east, north, up"};
}

TruthFinding one_position_finding(std::size_t poses, double estimate_spread) {
  return {.fault = TruthFault::kUnlikePath,
          .what = fmt::format("its position is the same in all {} poses, while the estimate's "
                              "spread over {:.3g} m: it has attitudes alone",
                              poses, estimate_spread),
          .value = static_cast<double>(poses),
          .unit = "poses",
          .advice =
              "errors and NEES of the position mean nothing; those of the attitude do, but for "
              "alignments by positions"};
}

TruthFinding mirrored_finding(const PositionFit& fit) {
  return {.fault = TruthFault::kMirrored,
          .what = fmt::format("its positions are mirrored: after the best rotation {:.3g} m are "
                              "left, and {:.3g} m after a reflection",
                              fit.rms, fit.mirrored_rms),
          .value = fit.rms,
          .threshold = fit.mirrored_rms / truth_limits::kMirrorGain,
          .unit = "m",
          .advice =
              "its axes are left-handed, or two of x, y, z are swapped: swap two columns or "
              "negate one, in the rotations too"};
}

std::optional<TruthFinding> unit_finding(double scale, std::string_view other) {
  struct Unit {
    const char* name;
    double per_metre;
  };
  constexpr std::array kUnits{Unit{"millimetres", 1000}, Unit{"centimetres", 100},
                              Unit{"feet", 1 / 0.3048},  Unit{"inches", 1 / 0.0254},
                              Unit{"kilometres", 0.001}, Unit{"decimetres", 10}};
  constexpr double kNear = 1.15, kOther = 2;
  const auto off = [&](double per_metre) { return std::abs(std::log(scale / per_metre)); };
  const Unit* found = nullptr;
  for (const Unit& unit : kUnits) {
    if (off(unit.per_metre) < std::log(kNear)) found = &unit;
  }
  if (found == nullptr && off(1) < std::log(kOther)) return std::nullopt;
  TruthFinding finding;
  finding.fault = TruthFault::kUnit;
  finding.value = scale;
  finding.threshold = kOther;
  if (found != nullptr) {
    finding.what = fmt::format("its positions are {:.5g} times {}: {}", scale, other, found->name);
    finding.advice = fmt::format("--truth-scale {:.6g} takes them to metres", 1 / found->per_metre);
  } else {
    finding.what =
        fmt::format("its positions are {:.4g} times {}, and of the same shape", scale, other);
    finding.advice =
        "its unit is not the metre (--truth-scale), or the scale of the estimate is "
        "wrong";
  }
  return finding;
}

TruthFinding tilt_finding(const TruthReference& reference, const Eigen::Vector3d& up, double tilt) {
  const double degrees = kDegrees * tilt;
  const bool axis = up.cwiseAbs().maxCoeff() > std::cos(5 * kRadians);
  return {.fault = TruthFault::kTilted,
          .what = fmt::format(
              "the z axis of its world is {:.1f} deg off {}{}", degrees,
              reference.level ? "the vertical of the estimate" : "that of the estimate's world",
              axis ? fmt::format(": its {}", axis_name(up)) : std::string()),
          .value = degrees,
          .threshold =
              kDegrees * (reference.level ? truth_limits::kTilt : truth_limits::kTiltOfUnknown),
          .unit = "deg",
          .advice =
              "--truth-level no removes the tilt; as it is, the figures of position + yaw and "
              "NEES are wrong, those after SE(3) are not"};
}

}  // namespace chasles
