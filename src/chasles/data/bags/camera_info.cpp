#include <algorithm>
#include <cmath>
#include <deque>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/data/bags/camera_info.hpp>
#include <chasles/data/lens.hpp>
#include <chasles/data/numbers.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

bool all_zero(const std::vector<double>& values, std::size_t from) {
  return std::all_of(values.begin() + static_cast<std::ptrdiff_t>(std::min(from, values.size())),
                     values.end(), [](double value) { return value == 0; });
}

// plumb_bob has k1, k2, p1, p2, k3; rational_polynomial the same and k4, k5, k6.
void read_lens(const RosCameraInfo& info, const std::string& where, Camera& camera) {
  const std::string& model = info.distortion_model;
  if (all_zero(info.D, 0) && (model.empty() || model == "plumb_bob" ||
                              model == "rational_polynomial" || model == "none")) {
    return;
  }
  const bool radial = model == "plumb_bob" || model == "rational_polynomial";
  const bool fisheye = model == "equidistant" || model == "fisheye";
  if ((!radial && !fisheye) || info.D.size() < 4 || !all_zero(info.D, 4)) {
    throw InputError(
        fmt::format("{}: the distortion model is '{}' with D = [{}], expected plumb_bob with k1, "
                    "k2, p1, p2 and no further coefficient, equidistant with four, or rectified "
                    "images: calibrate with one of these (Kalibr's files beside the bag have "
                    "precedence)",
                    where, model, fmt::join(info.D, ", ")));
  }
  camera.distortion = radial ? Distortion::kRadtan : Distortion::kEquidistant;
  camera.coefficients = Eigen::Vector4d(info.D[0], info.D[1], info.D[2], info.D[3]);
}

void check_finite_info(const RosCameraInfo& info, const std::string& where) {
  const auto finite = [](double value) { return std::isfinite(value); };
  if (std::all_of(info.D.begin(), info.D.end(), finite) &&
      std::all_of(info.K.begin(), info.K.end(), finite) &&
      std::all_of(info.P.begin(), info.P.end(), finite) &&
      std::all_of(info.R.begin(), info.R.end(), finite)) {
    return;
  }
  throw InputError(where + ": holds numbers that are not finite");
}

}  // namespace

Camera camera_of(const RosCameraInfo& info, bool rectified, const std::string& where) {
  check_finite_info(info, where);
  if (info.binning_x > 1 || info.binning_y > 1 || info.x_offset > 0 || info.y_offset > 0) {
    throw InputError(
        fmt::format("{}: states binning {} x {} and an offset of {}, {} px, expected "
                    "whole images: write the calibration of the images as they are "
                    "beside the bag (Kalibr's files)",
                    where, info.binning_x, info.binning_y, info.x_offset, info.y_offset));
  }
  const double fx = rectified ? info.P[0] : info.K[0], fy = rectified ? info.P[5] : info.K[4];
  if (!(fx > 0 && fy > 0)) {
    throw InputError(
        fmt::format("{}: the focal lengths are {} and {} px, expected positive ones: "
                    "the camera is not calibrated",
                    where, fx, fy));
  }
  Camera camera{.width = checked_pixels(where + ": width", info.width),
                .height = checked_pixels(where + ": height", info.height),
                .fx = fx,
                .fy = fy,
                .cx = rectified ? info.P[2] : info.K[2],
                .cy = rectified ? info.P[6] : info.K[5],
                .cam_T_imu = {}};
  if (!rectified) read_lens(info, where, camera);
  return camera;
}

std::optional<SE3> find_transform(const std::vector<RosTransform>& transforms,
                                  const std::string& to, const std::string& from) {
  std::map<std::string, SE3> known{{from, SE3{}}};  // frame_T_from
  std::deque<std::string> next{from};
  while (!next.empty() && !known.contains(to)) {
    const std::string frame = next.front();
    next.pop_front();
    for (const RosTransform& t : transforms) {
      if (t.child == frame && !known.contains(t.parent)) {
        known[t.parent] = t.parent_T_child * known[frame];
        next.push_back(t.parent);
      } else if (t.parent == frame && !known.contains(t.child)) {
        known[t.child] = t.parent_T_child.inverse() * known[frame];
        next.push_back(t.child);
      }
    }
  }
  const auto found = known.find(to);
  return found == known.end() ? std::nullopt : std::optional<SE3>(found->second);
}

}  // namespace chasles
