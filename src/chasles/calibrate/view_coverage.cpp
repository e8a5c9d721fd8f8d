#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/calibrate/view_coverage.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr double kWantedTilt = 0.35;         // of the target against the line to the camera [rad]
constexpr double kWantedDistances = 1.3;     // the farthest over the nearest
constexpr std::size_t kWantedTogether = 10;  // instants of two cameras

// In an image of three by three regions.
std::string region_name(int column, int row) {
  constexpr std::array kRowNames = {"upper", "", "lower"};
  constexpr std::array kColumnNames = {"left", "", "right"};
  const std::string vertical = kRowNames[static_cast<std::size_t>(row)];
  const std::string horizontal = kColumnNames[static_cast<std::size_t>(column)];
  if (vertical.empty()) return horizontal.empty() ? "middle" : horizontal + " side";
  return horizontal.empty() ? vertical + " side" : vertical + " " + horizontal;
}

}  // namespace

ViewCoverage::ViewCoverage(const std::vector<Camera>& cameras,
                           const std::vector<Eigen::Vector3d>& corners) {
  for (const Camera& camera : cameras) {
    cameras_.push_back({.width = camera.width, .height = camera.height});
  }
  for (const Eigen::Vector3d& corner : corners) {
    centre_ += corner / static_cast<double>(corners.size());
  }
}

void ViewCoverage::add(const TargetView& view) {
  OfCamera& seen = cameras_[static_cast<std::size_t>(view.camera)];
  ++seen.views;
  instants_[view.time].insert(static_cast<std::size_t>(view.camera));
  for (const Eigen::Vector2d& pixel : view.pixels) {
    const int i = static_cast<int>(kColumns * (pixel.x() + 0.5) / seen.width);
    const int j = static_cast<int>(kRows * (pixel.y() + 0.5) / seen.height);
    seen.covered[static_cast<std::size_t>(std::clamp(j, 0, kRows - 1))]
                [static_cast<std::size_t>(std::clamp(i, 0, kColumns - 1))] = true;
  }
}

void ViewCoverage::add_pose(int camera, const SE3& cam_T_target) {
  OfCamera& seen = cameras_[static_cast<std::size_t>(camera)];
  const Eigen::Vector3d centre = cam_T_target * centre_;
  seen.nearest = seen.nearest == 0 ? centre.norm() : std::min(seen.nearest, centre.norm());
  seen.farthest = std::max(seen.farthest, centre.norm());
  // How the normal of the target leans against the line to the camera.
  const Eigen::Vector3d normal = cam_T_target.R.col(2);
  const Eigen::Vector3d to_camera = -centre.normalized();
  const Eigen::Vector3d lean = so3::log(so3::between(to_camera, normal));
  for (int axis = 0; axis < 2; ++axis) {
    double* both = &seen.tilts[2 * static_cast<std::size_t>(axis)];
    both[0] = std::max(both[0], lean[axis]);
    both[1] = std::max(both[1], -lean[axis]);
  }
}

void ViewCoverage::clear_poses(int camera) {
  OfCamera& seen = cameras_[static_cast<std::size_t>(camera)];
  seen.tilts = {};
  seen.nearest = seen.farthest = 0;
}

std::vector<std::string> ViewCoverage::missing() const {
  std::vector<std::string> missing;
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    if (cameras_[c].views == 0) {
      missing.push_back(fmt::format("cam{}: it has not seen the target: show it", c));
    }
  }
  std::ranges::move(unlinked(), std::back_inserter(missing));
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    if (cameras_[c].views == 0) continue;
    if (std::string parts = open_parts(c, cameras_[c]); !parts.empty()) {
      missing.push_back(std::move(parts));
    }
  }
  for (std::size_t c = 0; c < cameras_.size(); ++c) {
    if (cameras_[c].views > 0) add_missing_poses(c, cameras_[c], missing);
  }
  return missing;
}

// Cameras that have views, but too few together with the first one or those that are linked to it.
std::vector<std::string> ViewCoverage::unlinked() const {
  const std::size_t n = cameras_.size();
  std::vector<std::vector<std::size_t>> together(n, std::vector<std::size_t>(n, 0));
  for (const auto& [time, cameras] : instants_) {
    for (const std::size_t a : cameras) {
      for (const std::size_t b : cameras) ++together[a][b];
    }
  }
  std::vector<bool> linked(n, false);
  if (n > 0) linked[0] = true;
  // The linked camera that a camera shares the most instants with.
  const auto partner = [&](std::size_t c) {
    std::size_t best = 0;
    for (std::size_t other = 0; other < n; ++other) {
      if (linked[other] && together[c][other] > together[c][best]) best = other;
    }
    return best;
  };
  for (std::size_t round = 1; round < n; ++round) {
    for (std::size_t c = 0; c < n; ++c) {
      if (!linked[c] && together[c][partner(c)] >= kWantedTogether) linked[c] = true;
    }
  }
  std::vector<std::string> missing;
  for (std::size_t c = 0; c < n; ++c) {
    if (linked[c] || cameras_[c].views == 0) continue;
    const std::size_t other = partner(c);
    missing.push_back(
        fmt::format("cam{}: it and cam{} see the target together at {} instants: show it to both "
                    "at a time, until there are {}",
                    c, other, together[c][other], kWantedTogether));
  }
  return missing;
}

std::string ViewCoverage::open_parts(std::size_t camera, const OfCamera& seen) {
  int open = 0;
  std::array<std::array<int, 3>, 3> of_regions{};
  for (int j = 0; j < kRows; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      if (seen.covered[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)]) continue;
      ++open;
      const int row = j == 0 ? 0 : j == kRows - 1 ? 2 : 1;
      ++of_regions[static_cast<std::size_t>(row)][static_cast<std::size_t>(i / 2)];
    }
  }
  if (open == 0) return "";
  int most = 0, column = 0, row = 0;
  for (const int j : {0, 2, 1}) {
    for (const int i :
         {0, 2, 1}) {  // corners first; a region of the middle row has twice the parts
      const int here = of_regions[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)];
      if (const int share = j == 1 ? here : 2 * here; share > most)
        most = share, column = i, row = j;
    }
  }
  return fmt::format(
      "cam{}: no corner in {} of {} parts of its image: show the target there, first at the {}",
      camera, open, kColumns * kRows, region_name(column, row));
}

void ViewCoverage::add_missing_poses(std::size_t camera, const OfCamera& seen,
                                     std::vector<std::string>& missing) {
  constexpr std::array kAxes = {"x", "x", "y", "y"};
  constexpr std::array kSigns = {"", "-", "", "-"};
  for (std::size_t k = 0; k < seen.tilts.size(); ++k) {
    if (seen.tilts[k] >= kWantedTilt) continue;
    missing.push_back(fmt::format(
        "cam{}: the target leans by at most {:.0f} degrees about the camera's {}{} axis: turn it "
        "by {:.0f} degrees more",
        camera, seen.tilts[k] * kDegrees, kSigns[k], kAxes[k],
        std::ceil((kWantedTilt - seen.tilts[k]) * kDegrees)));
  }
  if (seen.nearest > 0 && seen.farthest < kWantedDistances * seen.nearest) {
    missing.push_back(fmt::format(
        "cam{}: the target is {:.2f} to {:.2f} m away: show it nearer and farther, until the "
        "farthest is {} times the nearest",
        camera, seen.nearest, seen.farthest, kWantedDistances));
  }
}

}  // namespace chasles
