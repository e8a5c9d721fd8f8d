#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/calibration/image_corner.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/viewers/byte_sink.hpp>
#include <chasles/viewers/nerfstudio.hpp>

namespace chasles {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr std::uint8_t kPointGrey = 128;

// The model and its coefficients; our radtan is k1 k2 p1 p2 [k3], equidistant k1 k2 k3 k4.
OrderedJson lens_json(const Camera& camera) {
  const LensCoefficients& k = camera.coefficients;
  switch (camera.distortion) {
    case Distortion::kNone:
      return {{"camera_model", "OPENCV"}, {"k1", 0.0}, {"k2", 0.0}, {"p1", 0.0}, {"p2", 0.0}};
    case Distortion::kRadtan:
      if (k.size() > 5) break;
      return {{"camera_model", "OPENCV"},
              {"k1", k[0]},
              {"k2", k[1]},
              {"k3", k[4]},
              {"p1", k[2]},
              {"p2", k[3]}};
    case Distortion::kEquidistant:
      return {{"camera_model", "OPENCV_FISHEYE"},
              {"k1", k[0]},
              {"k2", k[1]},
              {"k3", k[2]},
              {"k4", k[3]}};
    default:
      break;
  }
  throw InputError(fmt::format(
      "nerfstudio has no lens model {} with {} coefficients, expected none, radtan with at most 5, "
      "or equidistant: --undistort makes images without distortion",
      name_of(camera.distortion), k.size()));
}

OrderedJson rows_of_matrix(const SE3& T) {
  OrderedJson rows = OrderedJson::array();
  for (int i = 0; i < 3; ++i) rows.push_back({T.R(i, 0), T.R(i, 1), T.R(i, 2), T.p(i)});
  return rows;
}

OrderedJson opengl_pose(SE3 world_T_cam) {
  world_T_cam.R.col(1) *= -1;
  world_T_cam.R.col(2) *= -1;
  OrderedJson rows = rows_of_matrix(world_T_cam);
  rows.push_back({0.0, 0.0, 0.0, 1.0});
  return rows;
}

std::string points_ply(const std::vector<Eigen::Vector3d>& points) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n"
      "property float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nend_header\n",
      points.size());
  for (const Eigen::Vector3d& p : points) {
    for (int k = 0; k < 3; ++k) append_little_endian(bytes, static_cast<float>(p(k)));
    for (int k = 0; k < 3; ++k) append_little_endian(bytes, kPointGrey);
  }
  return bytes;
}

}  // namespace

NerfstudioFiles run_nerfstudio(const Run& run, const PosedImages& posed,
                               const std::filesystem::path& folder) {
  const Camera& camera = posed.camera;
  OrderedJson transforms = lens_json(camera);
  transforms.update({{"fl_x", camera.fx},
                     {"fl_y", camera.fy},
                     {"cx", camera.cx + kFirstPixelCentre},
                     {"cy", camera.cy + kFirstPixelCentre},
                     {"w", camera.width},
                     {"h", camera.height},
                     {"applied_transform", rows_of_matrix(SE3{})},
                     {"ply_file_path", "sparse_pc.ply"}});
  OrderedJson frames = OrderedJson::array();
  for (const PosedImage& image : posed.images) {
    frames.push_back(
        {{"file_path", valid_utf8(std::filesystem::relative(image.file, folder).generic_string())},
         {"transform_matrix", opengl_pose(image.world_T_cam)}});
  }
  transforms["frames"] = std::move(frames);
  return {.transforms = transforms.dump(1) + "\n", .points = points_ply(finite_landmarks(run))};
}

}  // namespace chasles
