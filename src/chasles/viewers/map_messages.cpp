#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>
#include <nlohmann/json.hpp>

#include <chasles/eval/chi2.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/viewers/colours.hpp>
#include <chasles/viewers/foxglove.hpp>
#include <chasles/viewers/map_messages.hpp>
#include <chasles/viewers/point_cloud.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;

double sigma(const RunLandmark& l) { return std::sqrt(std::max(0.0, l.covariance.trace())); }

/// The finite landmarks, and the colours of their sigmas.
struct FiniteMap {
  explicit FiniteMap(const std::vector<RunLandmark>& landmarks) {
    for (const RunLandmark& l : landmarks) {
      if (l.p_world.allFinite() && l.covariance.allFinite()) finite.push_back(&l);
    }
  }
  SigmaColours colours() const {
    std::vector<double> sigmas;
    for (const RunLandmark* l : finite) sigmas.push_back(sigma(*l));
    return SigmaColours(std::move(sigmas));
  }

  std::vector<const RunLandmark*> finite = {};
};

Json sphere(const RunLandmark& l, const SigmaColours& colours) {
  const Ellipsoid shape = ellipsoid_95(l.covariance);
  const Rgb colour = colours(sigma(l));
  return {{"pose", proto_pose({shape.axes, l.p_world})},
          {"size", proto_vector(2 * shape.radii)},
          {"color",
           proto_colour(static_cast<unsigned>(colour[0] << 16 | colour[1] << 8 | colour[2]), 0.3)}};
}

}  // namespace

Ellipsoid ellipsoid_95(const Eigen::Matrix3d& covariance) {
  static const double kReach = std::sqrt(chi2_quantile(0.95, 3));
  const SymmetricEigen eigen = symmetric_eigen(covariance);
  Ellipsoid shape{.axes = eigen.vectors, .radii = kReach * eigen.values.cwiseMax(0).cwiseSqrt()};
  if (shape.axes.determinant() < 0) shape.axes.col(0) *= -1;
  return shape;
}

Json map_cloud(const std::vector<RunLandmark>& landmarks, Time time) {
  const FiniteMap map(landmarks);
  const SigmaColours colours = map.colours();
  PointCloud cloud("world");
  for (const RunLandmark* l : map.finite) {
    cloud.add({.p = l->p_world, .sigma = sigma(*l), .colour = colours(sigma(*l))});
  }
  return cloud.message(time);
}

Json map_ellipsoids(const std::vector<RunLandmark>& landmarks, Time time) {
  const FiniteMap map(landmarks);
  const SigmaColours colours = map.colours();
  Json spheres = Json::array();
  for (const RunLandmark* l : map.finite) spheres.push_back(sphere(*l, colours));
  return {{"entities", Json::array({{{"timestamp", proto_time(time)},
                                     {"frame_id", "world"},
                                     {"id", "landmarks"},
                                     {"spheres", std::move(spheres)}}})}};
}

}  // namespace chasles
