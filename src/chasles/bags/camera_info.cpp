#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <span>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/bags/camera_info.hpp>
#include <chasles/base/error.hpp>
#include <chasles/calibration/lens.hpp>
#include <chasles/codec/numbers.hpp>

namespace chasles {
namespace {

bool all_zero(const std::vector<double>& values) {
  return std::ranges::all_of(values, [](double value) { return value == 0; });
}

// Without a name and coefficients the images are without distortion, and so are those of a pinhole
// with zeros.
void read_lens(const RosCameraInfo& info, const std::string& where, Camera& camera) {
  const auto named = lens_model_named(info.distortion_model);
  const bool pinhole = named == Distortion::kRadtan || named == Distortion::kNone;
  if ((pinhole || info.distortion_model.empty()) && all_zero(info.D)) return;
  const bool can_be = named && *named != Distortion::kNone;
  const std::span<const double> stated =
      can_be ? without_padding(*named, info.D) : std::span<const double>();
  const std::string fault = can_be ? coefficients_fault(*named, stated) : expected_lenses();
  if (!fault.empty()) {
    throw InputError(
        fmt::format("{}: the distortion model is '{}' with D = [{}]: {}. Kalibr's files beside the "
                    "bag have precedence",
                    where, info.distortion_model, fmt::join(info.D, ", "), fault));
  }
  camera.distortion = *named;
  camera.coefficients = LensCoefficients(stated);
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
  struct Step {
    const std::string* frame;
    SE3 frame_T_this;
  };
  std::map<std::string_view, std::vector<Step>> steps;  // from each frame
  for (const RosTransform& t : transforms) {
    steps[t.child].push_back({&t.parent, t.parent_T_child});
    steps[t.parent].push_back({&t.child, t.parent_T_child.inverse()});
  }
  std::map<std::string_view, SE3> known{{from, SE3{}}};  // frame_T_from
  std::deque<std::string_view> next{from};
  while (!next.empty() && !known.contains(to)) {
    const std::string_view frame = next.front();
    next.pop_front();
    for (const Step& step : steps[frame]) {
      const SE3 frame_T_from = step.frame_T_this * known[frame];
      if (known.insert({*step.frame, frame_T_from}).second) next.push_back(*step.frame);
    }
  }
  const auto found = known.find(to);
  return found == known.end() ? std::nullopt : std::optional<SE3>(found->second);
}

std::optional<std::vector<std::size_t>> find_chain(const std::vector<RosTransform>& transforms,
                                                   const std::string& to, const std::string& from) {
  std::multimap<std::string_view, std::size_t> of_frame;
  for (std::size_t i = 0; i < transforms.size(); ++i) {
    of_frame.emplace(transforms[i].parent, i);
    of_frame.emplace(transforms[i].child, i);
  }
  std::map<std::string_view, std::size_t> by;  // the transform that led to each frame
  std::deque<std::string_view> next{from};
  const auto other_end = [&](std::size_t i, std::string_view frame) -> std::string_view {
    return transforms[i].parent == frame ? transforms[i].child : transforms[i].parent;
  };
  while (!next.empty() && !by.contains(to)) {
    const std::string_view frame = next.front();
    next.pop_front();
    const auto [begin, end] = of_frame.equal_range(frame);
    for (auto step = begin; step != end; ++step) {
      const std::string_view there = other_end(step->second, frame);
      if (there != from && by.emplace(there, step->second).second) next.push_back(there);
    }
  }
  if (to != from && !by.contains(to)) return std::nullopt;
  std::vector<std::size_t> chain;
  for (std::string_view frame = to; frame != from; frame = other_end(chain.back(), frame)) {
    chain.push_back(by.at(frame));
  }
  return chain;
}

}  // namespace chasles
