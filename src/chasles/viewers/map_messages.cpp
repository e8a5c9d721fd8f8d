#include <algorithm>
#include <cmath>

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

Json cloud(const std::vector<RunLandmark>& landmarks, const SigmaColours& colours, Time time) {
  PointCloud cloud("world");
  for (const RunLandmark& l : landmarks) {
    cloud.add({.p = l.p_world, .sigma = sigma(l), .colour = colours(sigma(l))});
  }
  return cloud.message(time);
}

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

void add_map(const std::vector<RunLandmark>& landmarks, Time time, Channels& out) {
  std::vector<RunLandmark> finite;
  std::vector<double> sigmas;
  for (const RunLandmark& l : landmarks) {
    if (!l.p_world.allFinite() || !l.covariance.allFinite()) continue;
    finite.push_back(l);
    sigmas.push_back(sigma(l));
  }
  const SigmaColours colours(sigmas);
  out.add("/map", "foxglove.PointCloud", time, cloud(finite, colours, time));
  Json spheres = Json::array();
  for (const RunLandmark& l : finite) spheres.push_back(sphere(l, colours));
  out.add("/map/ellipsoids", "foxglove.SceneUpdate", time,
          {{"entities", Json::array({{{"timestamp", proto_time(time)},
                                      {"frame_id", "world"},
                                      {"id", "landmarks"},
                                      {"spheres", std::move(spheres)}}})}});
}

}  // namespace chasles
