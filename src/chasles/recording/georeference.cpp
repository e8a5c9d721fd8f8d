#include <cmath>

#include <chasles/base/constants.hpp>
#include <chasles/recording/georeference.hpp>

namespace chasles {
namespace {

constexpr double kEarthRadius = 6378137;  // [m]

double scale(const Georeference& g) {
  return std::cos(g.origin.latitude * kRadians) * kEarthRadius;
}

Eigen::Vector3d project(double scale, const Geodetic& place) {
  return {scale * place.longitude * kRadians,
          scale * std::log(std::tan((90 + place.latitude) * kRadians / 2)), place.altitude};
}

}  // namespace

Eigen::Vector3d to_world(const Georeference& georeference, const Geodetic& place) {
  const double s = scale(georeference);
  return project(s, place) - project(s, georeference.origin);
}

Geodetic to_geodetic(const Georeference& georeference, const Eigen::Vector3d& p_world) {
  const double s = scale(georeference);
  const Eigen::Vector3d p = p_world + project(s, georeference.origin);
  return {.latitude = 2 * std::atan(std::exp(p.y() / s)) / kRadians - 90,
          .longitude = p.x() / (s * kRadians),
          .altitude = p.z()};
}

}  // namespace chasles
