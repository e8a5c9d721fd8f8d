#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/colmap_lens.hpp>
#include <chasles/calibration/image_corner.hpp>

namespace chasles {
namespace {

bool has_prism_terms(const LensCoefficients& k) {
  constexpr std::size_t kFirstPrismTerm = 8;
  return k.size() > kFirstPrismTerm &&
         std::any_of(k.begin() + kFirstPrismTerm, k.end(), [](double s) { return s != 0; });
}

// fx fy cx cy, then as many coefficients of the lens model; those that are not stated are 0.
std::vector<double> parameters_of(const Camera& camera, std::size_t coefficients) {
  std::vector<double> all{camera.fx, camera.fy, camera.cx + kFirstPixelCentre,
                          camera.cy + kFirstPixelCentre};
  for (std::size_t i = 0; i < coefficients; ++i) all.push_back(camera.coefficients[i]);
  return all;
}

}  // namespace

// Ids and parameters: COLMAP's sensor/models.h; pycolmap's projections agree with ours
// (python/tests/interop/test_colmap.py).
ColmapLens colmap_lens(const Camera& camera) {
  const auto lens = [&](int id, std::string_view name, std::size_t coefficients) {
    return ColmapLens{id, name, parameters_of(camera, coefficients)};
  };
  const LensCoefficients& k = camera.coefficients;
  switch (camera.distortion) {
    case Distortion::kNone:
      return lens(1, "PINHOLE", 0);
    case Distortion::kRadtan:
      if (k.is_zero()) return lens(1, "PINHOLE", 0);
      if (k.size() <= 4) return lens(4, "OPENCV", 4);
      if (has_prism_terms(k)) break;
      return lens(6, "FULL_OPENCV", 8);
    case Distortion::kEquidistant:
      return lens(5, "OPENCV_FISHEYE", 4);
    case Distortion::kFov:
      return lens(7, "FOV", 1);
    case Distortion::kFisheye624:
      return lens(11, "RAD_TAN_THIN_PRISM_FISHEYE", 12);
    case Distortion::kDivision:
      return lens(13, "DIVISION", 1);
    case Distortion::kEucm:
      return lens(16, "EUCM", 2);
    case Distortion::kDoubleSphere:
    case Distortion::kOmni:
      break;
  }
  throw InputError(fmt::format(
      "COLMAP has no lens model {}{}, expected none, radtan with at most 8 coefficients, "
      "equidistant, fov, division, eucm or fisheye624: `chasles export --as colmap --undistort` "
      "makes "
      "images without distortion",
      name_of(camera.distortion), has_prism_terms(k) ? " with prism terms" : ""));
}

std::string colmap_camera_lines(const std::vector<Camera>& cameras) {
  std::string text = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const ColmapLens lens = colmap_lens(cameras[i]);
    text += fmt::format("{} {} {} {} {}\n", i + 1, lens.name, cameras[i].width, cameras[i].height,
                        fmt::join(lens.parameters, " "));
  }
  return text;
}

}  // namespace chasles
