#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <chasles/report/against_truth.hpp>
#include <chasles/viewers/byte_sink.hpp>
#include <chasles/viewers/colours.hpp>
#include <chasles/viewers/placement.hpp>
#include <chasles/viewers/ply.hpp>

namespace chasles {
namespace {

enum class VertexKind : std::uint8_t { kLandmark, kEstimate, kTruth, kDeadReckoning, kPriorMap };

struct Vertex {
  Eigen::Vector3d p;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  VertexKind kind = VertexKind::kLandmark;
  Rgb colour{};
  std::int64_t landmark = -1;
  int observations = 0;
  int session = -1;
  bool returned = false;
};

struct Edge {
  std::size_t from, to;
};

constexpr const char* kVertexProperties =
    "property float x\nproperty float y\nproperty float z\n"
    "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar kind\n"
    "property float sigma\nproperty float cov_xx\nproperty float cov_xy\nproperty float cov_xz\n"
    "property float cov_yy\nproperty float cov_yz\nproperty float cov_zz\n"
    "property int landmark\nproperty int observations\n"
    "property int session\nproperty uchar returned\n";

double sigma(const Eigen::Matrix3d& covariance) {
  return std::sqrt(std::max(0.0, covariance.trace()));
}

std::vector<Vertex> landmark_vertices(const std::vector<RunLandmark>& landmarks) {
  std::vector<Vertex> vertices;
  std::vector<double> sigmas;
  for (const RunLandmark& l : landmarks) {
    if (!l.p_world.allFinite() || !l.covariance.allFinite()) continue;
    vertices.push_back({.p = l.p_world,
                        .covariance = l.covariance,
                        .colour = {},
                        .landmark = l.id,
                        .observations = l.observations});
    sigmas.push_back(sigma(l.covariance));
  }
  const SigmaColours colours(sigmas);
  for (Vertex& v : vertices) v.colour = colours(sigma(v.covariance));
  return vertices;
}

// The landmarks of a map in the frame `a`, but for those that are known otherwise.
std::vector<Vertex> map_vertices(const MapSketch& map, const SE3& a_T_map,
                                 const std::set<LandmarkId>& known) {
  std::vector<Vertex> vertices;
  for (const SketchPoint& l : map.points) {
    if (known.contains(l.id)) continue;
    vertices.push_back({.p = a_T_map * l.p_map,
                        .covariance = a_T_map.R * l.covariance * a_T_map.R.transpose(),
                        .kind = VertexKind::kPriorMap,
                        .colour = rgb(session_colour(l.session)),
                        .landmark = l.id,
                        .observations = l.observations,
                        .session = l.session});
  }
  return vertices;
}

class Drawing {
 public:
  explicit Drawing(std::vector<Vertex> vertices) : vertices_(std::move(vertices)) {}
  explicit Drawing(const Run& run) : vertices_(landmark_vertices(run.landmarks)) {
    if (run.prior_map) add_prior_map(*run.prior_map, recognised_landmarks(run));
    for (const RunState& s : run.states) {
      add({.p = s.world_T_imu.p,
           .covariance = s.pose_covariance.bottomRightCorner<3, 3>(),
           .kind = VertexKind::kEstimate,
           .colour = rgb(kEstimateColour)});
    }
    const AgainstTruth errors = against_truth(run);
    if (errors.problem.empty()) {
      add_way(run.truth, errors.world_T_truth_first, VertexKind::kTruth, kTruthColour);
    }
    add_way(run.dead_reckoning, {}, VertexKind::kDeadReckoning, kDeadReckoningColour);
  }

  std::string bytes(std::string_view frame, PlyEdges wanted) const {
    std::string out = fmt::format(
        "ply\nformat binary_little_endian 1.0\n"
        "comment metres, the frame of {}\n"
        "comment kind: 0 landmark, 1 estimate, 2 truth, 3 dead reckoning, 4 landmark of a map\n"
        "element vertex {}\n{}",
        frame, vertices_.size(), kVertexProperties);
    if (wanted == PlyEdges::kYes) {
      out += fmt::format("element edge {}\nproperty int vertex1\nproperty int vertex2\n",
                         edges_.size());
    }
    out += "end_header\n";
    for (const Vertex& v : vertices_) append(v, out);
    if (wanted == PlyEdges::kNo) return out;
    for (const Edge& e : edges_) {
      append_little_endian(out, static_cast<std::int32_t>(e.from));
      append_little_endian(out, static_cast<std::int32_t>(e.to));
    }
    return out;
  }

 private:
  // Landmarks of the map are among the run's own, with what it has learned of them.
  void add_prior_map(const MapSketch& map, const std::set<LandmarkId>& recognised) {
    std::map<LandmarkId, int> sessions;
    for (const SketchPoint& l : map.points) sessions[l.id] = l.session;
    std::set<LandmarkId> known;
    for (Vertex& v : vertices_) {
      const auto of_map = sessions.find(v.landmark);
      if (of_map == sessions.end()) continue;
      v.kind = VertexKind::kPriorMap;
      v.session = of_map->second;
      v.colour = rgb(session_colour(v.session));
      v.returned = recognised.contains(v.landmark);
      known.insert(v.landmark);
    }
    const std::vector<Vertex> others = map_vertices(map, map.world_T_map, known);
    vertices_.insert(vertices_.end(), others.begin(), others.end());
  }

  static void append(const Vertex& v, std::string& out) {
    const auto add_float = [&](double x) { append_little_endian(out, static_cast<float>(x)); };
    for (int k = 0; k < 3; ++k) add_float(v.p(k));
    for (const std::uint8_t part : v.colour) append_little_endian(out, part);
    append_little_endian(out, static_cast<std::uint8_t>(v.kind));
    add_float(sigma(v.covariance));
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) add_float(v.covariance(i, j));
    }
    // PLY has no larger integers: a larger number becomes -1.
    append_little_endian(
        out, std::in_range<std::int32_t>(v.landmark) ? static_cast<std::int32_t>(v.landmark) : -1);
    append_little_endian(out, v.observations);
    append_little_endian(out, v.session);
    append_little_endian(out, static_cast<std::uint8_t>(v.returned));
  }

  void add(const Vertex& vertex) {
    if (!vertex.p.allFinite() || !vertex.covariance.allFinite()) return;
    const bool goes_on = !vertices_.empty() && vertices_.back().kind == vertex.kind;
    if (goes_on) edges_.push_back({vertices_.size() - 1, vertices_.size()});
    vertices_.push_back(vertex);
  }

  void add_way(const Trajectory& way, const SE3& placed, VertexKind kind, unsigned colour) {
    for (const StampedPose& s : way)
      add({.p = placed * s.pose.p, .kind = kind, .colour = rgb(colour)});
  }

  std::vector<Vertex> vertices_;
  std::vector<Edge> edges_;
};

}  // namespace

std::string run_ply(const Run& run, PlyEdges edges) {
  return Drawing(run).bytes("trajectory.tum", edges);
}

std::string map_ply(const MapSketch& map) {
  return Drawing(map_vertices(map, {}, {})).bytes("the map", PlyEdges::kNo);
}

}  // namespace chasles
