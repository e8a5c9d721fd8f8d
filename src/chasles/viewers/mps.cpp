#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <stdexcept>
#include <vector>
#include <zlib.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/imu/imu_sample.hpp>
#include <chasles/viewers/mps.hpp>
#include <chasles/viewers/path_motion.hpp>

namespace chasles {
namespace {

using Vector3 = Eigen::Vector3d;

// The reader stops, without an error, at a number that is not finite.
bool are_finite(const Vector3& a, const Vector3& b) { return a.allFinite() && b.allFinite(); }

double gravity_of(std::string_view summary) {
  const auto json = nlohmann::json::parse(summary, nullptr, false);
  const nlohmann::json::json_pointer place("/settings/start.gravity");
  const bool stated = !json.is_discarded() && json.contains(place) && json.at(place).is_number();
  return stated ? json.at(place).get<double>() : kStandardGravity;
}

// One world has one uid, in both files and on either path.
std::string world_uid(const Run& run) {
  std::string poses;
  for (const RunState& s : run.states) {
    append_tum(s.time, s.world_T_imu, poses);
    poses += '\n';
  }
  return fmt::format("chasles-{:08x}",
                     crc32_z(0, reinterpret_cast<const Bytef*>(poses.data()), poses.size()));
}

double quality_of(const std::string& health) {
  if (health == "ok") return 1;
  return health == "degraded" ? 0.5 : 0;
}

std::string trajectory_text(const ReportRun& run, RunPath path, const std::string& uid) {
  const std::vector<SmoothedPose> poses = path_poses(run.run, path);
  if (poses.size() < 2) {
    throw InputError(
        fmt::format("run '{}' has one pose, expected at least two: the format has "
                    "velocities",
                    run.run.name));
  }
  std::map<Time, const RunState*> states;
  for (const RunState& s : run.run.states) states.emplace(s.time, &s);
  const auto velocity = extra_vector_at(run.run, "velocity");
  const double gravity = gravity_of(run.summary);
  std::string text =
      "graph_uid,tracking_timestamp_us,utc_timestamp_ns,tx_world_device,ty_world_device,"
      "tz_world_device,qx_world_device,qy_world_device,qz_world_device,qw_world_device,"
      "device_linear_velocity_x_device,device_linear_velocity_y_device,"
      "device_linear_velocity_z_device,angular_velocity_x_device,angular_velocity_y_device,"
      "angular_velocity_z_device,gravity_x_world,gravity_y_world,gravity_z_world,quality_score\n";
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const SE3& world_T_device = poses[i].world_T_imu;
    const auto state = states.find(poses[i].time);
    PathMotion motion = motion_at(poses, i);
    if (path == RunPath::kStates && velocity) {
      const auto& extra = state->second->extra;
      motion.velocity = world_T_device.R.transpose() *
                        Vector3(extra[*velocity], extra[*velocity + 1], extra[*velocity + 2]);
    }
    const auto& [v, w] = motion;
    if (!are_finite(v, w)) continue;
    const Eigen::Vector4d q = unit_quaternion(world_T_device.R);
    const Vector3& p = world_T_device.p;
    fmt::format_to(std::back_inserter(text),
                   "{},{},-1,{},{},{},{},{},{},{},{},{},{},{},{},{},0,0,{},{}\n", uid,
                   std::chrono::floor<std::chrono::microseconds>(poses[i].time).count(), p.x(),
                   p.y(), p.z(), q[0], q[1], q[2], q[3], v.x(), v.y(), v.z(), w.x(), w.y(), w.z(),
                   -gravity, state == states.end() ? 1 : quality_of(state->second->health));
  }
  return text;
}

// The position of the IMU at that time, or at the first state after it.
std::optional<Vector3> position_at(const Run& run, Time time) {
  const auto state = std::ranges::lower_bound(run.states, time, {}, &RunState::time);
  if (state == run.states.end() || !is_finite(state->world_T_imu)) return std::nullopt;
  return state->world_T_imu.p;
}

std::string points_text(const Run& run, const std::string& uid) {
  std::string text = "uid,graph_uid,px_world,py_world,pz_world,inv_dist_std,dist_std\n";
  for (std::size_t i = 0; i < run.landmarks.size(); ++i) {
    const RunLandmark& l = run.landmarks[i];
    const auto seen_from = position_at(run, l.first_seen);
    if (!seen_from || !l.p_world.allFinite() || !l.covariance.allFinite()) continue;
    const double distance = (l.p_world - *seen_from).norm();
    const Vector3 ray = (l.p_world - *seen_from) / distance;
    const double sigma = std::sqrt(std::max(0.0, ray.dot(l.covariance * ray)));
    const double inverse_sigma = sigma / (distance * distance);
    if (!std::isfinite(sigma) || !std::isfinite(inverse_sigma)) continue;
    // The reader's numbers have 32 bits and no sign: a landmark's may not fit.
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{}\n", i, uid, l.p_world.x(),
                   l.p_world.y(), l.p_world.z(), inverse_sigma, sigma);
  }
  return text;
}

// A gzip file without a name and a time: the same bytes for the same text.
std::string gzipped(const std::string& text) {
  constexpr int kGzipWindow = 15 + 16, kMemoryLevel = 8;
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, kGzipWindow, kMemoryLevel,
                   Z_DEFAULT_STRATEGY) != Z_OK) {
    throw std::runtime_error("zlib does not start");
  }
  std::string bytes(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  const int ended = deflate(&stream, Z_FINISH);
  bytes.resize(stream.total_out);
  deflateEnd(&stream);
  if (ended != Z_STREAM_END) throw std::runtime_error("zlib does not end");
  return bytes;
}

}  // namespace

MpsFiles run_mps(const ReportRun& run, RunPath path) {
  if (!is_level(run.run)) {
    throw InputError(fmt::format(
        "run '{}' does not know gravity, which each pose of this format states, expected a run "
        "with an IMU",
        run.run.name));
  }
  const std::string uid = world_uid(run.run);
  return {.trajectory = trajectory_text(run, path, uid),
          .points = gzipped(points_text(run.run, uid))};
}

}  // namespace chasles
