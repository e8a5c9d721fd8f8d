#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <chasles/check/check_calibration.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr double kLeastBaseline = 0.005, kMostBaseline = 3;  // [m]
constexpr double kBehind = 0.5;                              // share of the pairs
constexpr double kEpipolar = 4, kFits = 1.5;                 // [px]
constexpr double kParallax = 0.005;  // below it a pair's depth has no sign [rad]
constexpr std::size_t kFewestMatches = 50, kMostMatches = 20000;

struct PixelsSeen {
  Eigen::Vector2d cam0, other;
};

struct RaysSeen {
  Eigen::Vector3d cam0, other;
};

std::vector<PixelsSeen> seen_by_both(int other, const std::vector<FeatureFrame>& frames) {
  std::vector<PixelsSeen> pairs;
  for (const FeatureFrame& frame : frames) {
    std::map<LandmarkId, Eigen::Vector2d> first;
    for (const PixelObservation& o : frame.pixels) {
      if (o.camera == 0) first[o.landmark] = o.pixel;
    }
    for (const PixelObservation& o : frame.pixels) {
      if (o.camera != other || !first.contains(o.landmark)) continue;
      pairs.push_back({first[o.landmark], o.pixel});
      if (pairs.size() == kMostMatches) return pairs;
    }
  }
  return pairs;
}

std::vector<RaysSeen> rays_of_pairs(const std::vector<PixelsSeen>& pixels, const Camera& cam0,
                                    const Camera& other) {
  std::vector<RaysSeen> pairs;
  for (const PixelsSeen& pair : pixels) {
    const auto a = wide_ray(cam0, pair.cam0), b = wide_ray(other, pair.other);
    if (a && b) pairs.push_back({a->ray.normalized(), b->ray.normalized()});
  }
  return pairs;
}

struct PairsCheck {
  double behind = 0;    // share of the pairs with parallax that lie behind a camera
  double epipolar = 0;  // median distance from the epipolar line [px]
};

PairsCheck check_pairs(const std::vector<RaysSeen>& pairs, const SE3& other_T_cam0, double focal) {
  std::vector<double> distances;
  double behind = 0, counted = 0;
  for (const RaysSeen& pair : pairs) {
    const Eigen::Vector3d a = other_T_cam0.R * pair.cam0;
    const Eigen::Vector3d normal = other_T_cam0.p.cross(a);
    distances.push_back(focal * std::abs(normal.normalized().dot(pair.other)));
    const Eigen::Vector3d across = a.cross(pair.other);
    if (across.norm() < kParallax) continue;
    // depth a + p = depth' b: the cross products with the two rays give both depths.
    const double depth0 = -other_T_cam0.p.cross(pair.other).dot(across);
    const double depth1 = -other_T_cam0.p.cross(a).dot(across);
    behind += depth0 < 0 || depth1 < 0 ? 1 : 0;
    ++counted;
  }
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return {.behind = counted > 0 ? behind / counted : 0, .epipolar = *middle};
}

void report_pairs(const PairsCheck& check, const std::string& about, const std::string& advice,
                  CheckReport& report) {
  report.facts.push_back({about, "off the epipolar line", check.epipolar, "px"});
  if (check.behind > kBehind) {
    report.findings.push_back(
        {.severity = Severity::kError,
         .about = about,
         .what = fmt::format("{:.0f} % of the points that both see would lie behind the cameras",
                             100 * check.behind),
         .value = 100 * check.behind,
         .threshold = 100 * kBehind,
         .unit = "%",
         .advice = "the images are swapped, or the baseline has the wrong sign"});
  }
  if (check.epipolar <= kEpipolar) return;
  report.findings.push_back(
      {.severity = Severity::kError,
       .about = about,
       .what =
           fmt::format("points that both see lie {:.1f} px off the epipolar lines", check.epipolar),
       .value = check.epipolar,
       .threshold = kEpipolar,
       .unit = "px",
       .advice = advice});
}

// Changes of the calibration that bring the points onto their epipolar lines.
std::string pairs_advice(const std::vector<PixelsSeen>& pixels, const Camera& cam0,
                         const Camera& other, const std::string& about) {
  const SE3 other_T_cam0 = other.cam_T_imu * cam0.cam_T_imu.inverse();
  const auto fits = [&](const Camera& first, const Camera& second, const SE3& second_T_first) {
    const auto rays = rays_of_pairs(pixels, first, second);
    if (rays.size() < kFewestMatches) return false;
    const PairsCheck check = check_pairs(rays, second_T_first, focal_lengths_at_axis(second).x());
    return check.epipolar < kFits && check.behind < kBehind;
  };
  if (fits(other, cam0, other_T_cam0.inverse())) {
    return fmt::format(
        "the calibrations of cam0 and {} are exchanged, or their images: with the "
        "other's calibration each fits",
        about);
  }
  if (fits(cam0, other, other_T_cam0.inverse())) {
    return fmt::format("the transform from cam0 to {} is inverted: with the inverse the points fit",
                       about);
  }
  return "calibrate the cameras against each other again";
}

void report_baseline(double baseline, const std::string& about, CheckReport& report) {
  report.facts.push_back({about, "baseline", baseline, "m"});
  if (baseline >= kLeastBaseline && baseline <= kMostBaseline) return;
  const bool small = baseline < kLeastBaseline;
  report.findings.push_back(
      {.severity = Severity::kWarning,
       .about = about,
       .what = fmt::format("it is {:.4g} m from cam0", baseline),
       .value = baseline,
       .threshold = small ? kLeastBaseline : kMostBaseline,
       .unit = "m",
       .advice = small ? "expected a different position: was cam0's calibration copied?"
                       : "expected metres: is the translation in millimetres?"});
}

}  // namespace

void report_stereo(const std::vector<Camera>& cameras, const std::vector<FeatureFrame>& frames,
                   CheckReport& report) {
  for (std::size_t c = 1; c < cameras.size(); ++c) {
    const std::string about = fmt::format("cam{}", c);
    const SE3 other_T_cam0 = cameras[c].cam_T_imu * cameras[0].cam_T_imu.inverse();
    report_baseline(other_T_cam0.p.norm(), about, report);
    const double angle = so3::log(other_T_cam0.R).norm() * 180 / std::numbers::pi;
    report.facts.push_back({about, "angle to cam0", angle, "deg"});
    const auto pixels = seen_by_both(static_cast<int>(c), frames);
    const auto pairs = rays_of_pairs(pixels, cameras[0], cameras[c]);
    if (pairs.size() < kFewestMatches || other_T_cam0.p.norm() < kLeastBaseline) continue;
    const PairsCheck check =
        check_pairs(pairs, other_T_cam0, focal_lengths_at_axis(cameras[c]).x());
    const bool off = check.epipolar > kEpipolar;
    report_pairs(check, about, off ? pairs_advice(pixels, cameras[0], cameras[c], about) : "",
                 report);
  }
}

void report_rectified(const std::vector<FeatureFrame>& frames, CheckReport& report) {
  std::vector<double> rows;
  double all = 0, negative = 0;
  for (const FeatureFrame& frame : frames) {
    for (const StereoObservation& o : frame.observations) {
      rows.push_back(std::abs(o.pixels[1] - o.pixels[3]));
      negative += o.pixels[0] < o.pixels[2] ? 1 : 0;
      ++all;
    }
  }
  if (all < static_cast<double>(kFewestMatches)) return;
  const auto middle = rows.begin() + static_cast<std::ptrdiff_t>(rows.size() / 2);
  std::nth_element(rows.begin(), middle, rows.end());
  report_pairs({.behind = negative / all, .epipolar = *middle}, "stereo", "rectify the pair again",
               report);
}

}  // namespace chasles
