#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <nlohmann/json.hpp>

#include <chasles/eval/chi2.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/viewers/byte_sink.hpp>
#include <chasles/viewers/colours.hpp>
#include <chasles/viewers/foxglove.hpp>
#include <chasles/viewers/map_messages.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;

double sigma(const RunLandmark& l) { return std::sqrt(std::max(0.0, l.covariance.trace())); }

// NumericType of foxglove.PackedElementField.
constexpr int kUint8 = 1, kFloat32 = 7;

Json cloud(const std::vector<RunLandmark>& landmarks, const SigmaColours& colours, Time time) {
  std::string bytes;
  for (const RunLandmark& l : landmarks) {
    for (int k = 0; k < 3; ++k) append_little_endian(bytes, static_cast<float>(l.p_world(k)));
    append_little_endian(bytes, static_cast<float>(sigma(l)));
    for (const std::uint8_t part : colours(sigma(l))) append_little_endian(bytes, part);
    append_little_endian(bytes, std::uint8_t{255});
  }
  Json fields = Json::array();
  unsigned offset = 0;
  const auto add = [&](const char* name, int type, unsigned size) {
    fields.push_back({{"name", name}, {"offset", offset}, {"type", type}});
    offset += size;
  };
  for (const char* name : {"x", "y", "z", "sigma"}) add(name, kFloat32, 4);
  for (const char* name : {"red", "green", "blue", "alpha"}) add(name, kUint8, 1);
  return {{"timestamp", proto_time(time)},
          {"frame_id", "world"},
          {"pose", proto_pose({})},
          {"point_stride", offset},
          {"fields", fields},
          {"data", Json::binary({bytes.begin(), bytes.end()})}};
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
