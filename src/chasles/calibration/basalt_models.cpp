#include <chasles/calibration/basalt_models.hpp>

namespace chasles {

const std::vector<BasaltModel>& basalt_models() {
  static const std::vector<BasaltModel> models{
      {"pinhole", Distortion::kNone, {}},
      {"pinhole-radtan8", Distortion::kRadtan, {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}},
      {"kb4", Distortion::kEquidistant, {"k1", "k2", "k3", "k4"}},
      {"ds", Distortion::kDoubleSphere, {"xi", "alpha"}},
      {"eucm", Distortion::kEucm, {"alpha", "beta"}},
      {"ucm", Distortion::kEucm, {"alpha"}},
      {"fov", Distortion::kFov, {"w"}}};
  return models;
}

}  // namespace chasles
