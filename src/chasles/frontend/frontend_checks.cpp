#include <cmath>
#include <cstddef>
#include <string>

#include <Eigen/LU>

#include <chasles/base/error.hpp>
#include <chasles/frontend/frontend_checks.hpp>
#include <chasles/frontend/image_pyramid.hpp>

namespace chasles {
namespace {

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

void check_camera(const Camera& camera, std::size_t index) {
  const bool good = camera.width > PyramidLevel::kPad && camera.height > PyramidLevel::kPad &&
                    std::isfinite(camera.fx) && std::isfinite(camera.fy) && camera.fx > 0 &&
                    camera.fy > 0 && std::isfinite(camera.cx) && std::isfinite(camera.cy) &&
                    camera.coefficients.is_finite() && camera.cam_T_imu.R.allFinite() &&
                    camera.cam_T_imu.p.allFinite();
  if (good) return;
  throw UsageError("camera " + std::to_string(index) + ": found " +
                   size_text(camera.width, camera.height) + " pixels, focal lengths " +
                   std::to_string(camera.fx) + ", " + std::to_string(camera.fy) +
                   "; expected finite numbers, focal lengths above 0, and more than " +
                   std::to_string(PyramidLevel::kPad) + " pixels per side");
}

void check_mask(const GrayImage& mask, const Camera& camera, std::size_t index) {
  if (mask.empty()) return;
  const auto pixels =
      static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  if (mask.width == camera.width && mask.height == camera.height && mask.pixels.size() == pixels) {
    return;
  }
  throw UsageError("mask of camera " + std::to_string(index) + ": found " +
                   size_text(mask.width, mask.height) + ", expected " +
                   size_text(camera.width, camera.height) + " as the camera's images");
}

void check_image(const GrayImage& image, const Camera& camera, std::size_t index, Time time) {
  if (image.empty()) return;
  const auto pixels =
      static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  if (image.width == camera.width && image.height == camera.height &&
      image.pixels.size() == pixels) {
    return;
  }
  throw InputError("image of camera " + std::to_string(index) + " at " +
                   std::to_string(time.count()) + " ns: found " +
                   size_text(image.width, image.height) + " (" +
                   std::to_string(image.pixels.size()) + " bytes), expected " +
                   size_text(camera.width, camera.height) + " as in its calibration");
}

void check_rotation(const Eigen::Matrix3d& R, Time time) {
  const double error = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (R.allFinite() && error < 1e-6 && R.determinant() > 0) return;
  throw InputError("predicted rotation at " + std::to_string(time.count()) +
                   " ns: found a matrix with an orthogonality error of " + std::to_string(error) +
                   ", expected a rotation; check the gyroscope's samples for NaN");
}

}  // namespace

void check_rig(const std::vector<Camera>& cameras, const std::vector<GrayImage>& masks) {
  if (cameras.empty()) throw UsageError("cameras: found none, expected at least one");
  if (masks.size() != cameras.size()) {
    throw UsageError("masks: found " + std::to_string(masks.size()) + ", expected none or " +
                     std::to_string(cameras.size()) + ", one per camera");
  }
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    check_camera(cameras[i], i);
    check_mask(masks[i], cameras[i], i);
  }
}

void check_frame(const ImageFrame& frame, const RotationPrior& rotation, std::optional<Time> last,
                 const std::vector<Camera>& cameras) {
  if (last && frame.time <= *last) {
    throw InputError("image frame: found time " + std::to_string(frame.time.count()) +
                     " ns after " + std::to_string(last->count()) +
                     " ns, expected rising times; drop or sort the frames");
  }
  if (frame.images.size() != cameras.size()) {
    throw InputError("image frame at " + std::to_string(frame.time.count()) + " ns: found " +
                     std::to_string(frame.images.size()) + " images, expected " +
                     std::to_string(cameras.size()) +
                     ", one per camera (empty if a camera has none)");
  }
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    check_image(frame.images[i], cameras[i], i, frame.time);
  }
  check_rotation(rotation.now_R_last_imu, frame.time);
}

}  // namespace chasles
