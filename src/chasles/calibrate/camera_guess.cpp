#include <algorithm>
#include <cmath>
#include <limits>

#include <chasles/base/constants.hpp>
#include <chasles/calibrate/camera_guess.hpp>
#include <chasles/calibrate/target_pose.hpp>

namespace chasles {
namespace {

constexpr std::size_t kViews = 12;   // that are compared
constexpr double kStep = 1.12;       // of one focal length to the next
constexpr double kLossWidth = 3;     // [px]
constexpr double kUnexplained = 50;  // error of a view without a pose [px]

// Those with most corners, spread over the recording: the best of each part.
std::vector<const TargetView*> spread_views(const std::vector<const TargetView*>& views) {
  std::vector<const TargetView*> chosen;
  const std::size_t parts = std::min(kViews, views.size());
  for (std::size_t part = 0; part < parts; ++part) {
    const auto begin = views.begin() + static_cast<std::ptrdiff_t>(part * views.size() / parts);
    const auto end = views.begin() + static_cast<std::ptrdiff_t>((part + 1) * views.size() / parts);
    chosen.push_back(*std::max_element(begin, end, [](const TargetView* a, const TargetView* b) {
      return a->ids.size() < b->ids.size();
    }));
  }
  return chosen;
}

double mean_error(const Camera& camera, std::span<const Eigen::Vector3d> corners,
                  const std::vector<const TargetView*>& views) {
  double sum = 0;
  for (const TargetView* view : views) {
    const auto pose = target_pose(camera, corners, *view, kLossWidth);
    sum += pose ? std::min(pose->rms, kUnexplained) : kUnexplained;
  }
  return sum / static_cast<double>(views.size());
}

}  // namespace

std::optional<Camera> guessed_camera(const Camera& size, std::span<const Eigen::Vector3d> corners,
                                     const std::vector<const TargetView*>& views) {
  const std::vector<const TargetView*> chosen = spread_views(views);
  if (chosen.empty()) return std::nullopt;
  std::optional<Camera> best;
  double least = kUnexplained;
  const double half = 0.5 * size.width;
  for (double focal = half / (115 * kRadians); focal < half / (10 * kRadians); focal *= kStep) {
    for (const double k1 : {-0.08, 0.0, 0.15, 0.33}) {  // 1/3: nearly a pinhole
      Camera camera = size;
      camera.fx = camera.fy = focal;
      camera.cx = 0.5 * (size.width - 1);
      camera.cy = 0.5 * (size.height - 1);
      camera.distortion = Distortion::kEquidistant;
      camera.coefficients = {k1, 0, 0, 0};
      const double error = mean_error(camera, corners, chosen);
      if (error < least) {
        least = error;
        best = camera;
      }
    }
  }
  return best;
}

}  // namespace chasles
