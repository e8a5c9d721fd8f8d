#include <optional>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/mat_file.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/tracks.hpp>

namespace chasles {
namespace {

StereoRig read_rig(const MatFile& file) {
  const auto number = [&](const std::string& field) { return checked_scalar(file.read(field)); };
  const auto positive = [&](const std::string& field) {
    return checked_positive(file.where(field), number(field));
  };
  const Eigen::Matrix3d C = checked_rotation(
      file.where("C_c_v"), checked_matrix(file.read("C_c_v"), 3, 3, "vehicle to camera"));
  const Eigen::Vector3d rho =
      checked_matrix(file.read("rho_v_c_v"), 3, 1, "the camera's position on the vehicle");
  // rho is measured in the vehicle's axes: p_cam = C (p_vehicle - rho).
  return {.fx = positive("fu"),
          .fy = positive("fv"),
          .cx = number("cu"),
          .cy = number("cv"),
          .baseline = positive("b"),
          .cam0_T_imu = {C, -(C * rho)}};
}

TrackTable read_tracks(const MatFile& file, std::size_t times) {
  const std::string where = file.where("y_k_j");
  std::optional<TrackCollector> collector;
  file.visit(
      "y_k_j",
      [&](const std::vector<std::size_t>& shape) {
        if (shape.size() < 2 || shape.size() > 3 || shape[0] != 4) {
          throw InputError(
              fmt::format("{}: has shape {}, expected (4, K, M): four pixels of M "
                          "landmarks in K frames ({} time stamps)",
                          where, shape_text(shape), times));
        }
        collector.emplace(shape.size() == 3 ? shape[2] : 1, shape[1],
                          TrackCollector::Order::kTrackFramePixel, where);
      },
      [&](std::span<const double> values) { collector->add(values); });
  return std::move(*collector).finish();
}

void read_truth(const MatFile& file, const std::vector<Time>& times, Recording& recording) {
  if (!file.has("r_i_vk_i") && !file.has("theta_vk_i")) return;
  const std::string why = "one column a time stamp";
  const auto r = checked_columns(file.read("r_i_vk_i"), 3, times.size(), why);
  const auto theta = checked_columns(file.read("theta_vk_i"), 3, times.size(), why);
  for (std::size_t k = 0; k < times.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    recording.truth.push_back(
        {.time = times[k], .pose = {so3::exp(theta.col(column)), r.col(column)}});
  }
}

void read_true_landmarks(const MatFile& file, std::size_t tracks, Recording& recording) {
  if (!file.has("rho_i_pj_i")) return;
  const auto rho = checked_matrix(file.read("rho_i_pj_i"), 3, tracks, "one column a landmark");
  for (Eigen::Index j = 0; j < rho.cols(); ++j) {
    recording.true_landmarks.push_back({.id = static_cast<LandmarkId>(j), .p_world = rho.col(j)});
  }
}

// The files state variances (`y_var` and so on); absent ones stay unstated.
void read_stated_noise(const MatFile& file, Recording& recording) {
  const auto sigma = [&](const std::string& field, std::size_t rows) -> Eigen::VectorXd {
    const auto variances = checked_matrix(file.read(field), rows, 1, "variances");
    for (Eigen::Index i = 0; i < variances.rows(); ++i) {
      checked_positive(file.where(field), variances(i, 0));
    }
    return variances.cwiseSqrt();
  };
  if (file.has("v_var") && file.has("w_var")) {
    recording.velocity_sigma =
        BodyVelocitySigma{.linear = sigma("v_var", 3), .angular = sigma("w_var", 3)};
    recording.remarks.push_back("the file states the noise of its velocities (v_var, w_var)");
  }
  if (file.has("y_var")) {
    recording.pixel_sigma = sigma("y_var", 4);
    recording.remarks.push_back("the file states the noise of its pixels (y_var)");
  }
}

}  // namespace

Recording read_mat_recording(const std::filesystem::path& path) {
  const MatFile file(path);
  Recording recording;
  recording.name = path.stem().string();
  std::vector<Time> times = checked_times(file.read("t"));
  recording.rig = read_rig(file);
  TrackTable table = read_tracks(file, times.size());
  // Some recordings have tracks in a part only: the rest is left out.
  const std::size_t frames = std::min(times.size(), table.frames);
  if (times.size() != table.frames) {
    recording.remarks.push_back(fmt::format("{} time stamps and {} frames: the first {} are used",
                                            times.size(), table.frames, frames));
    times.resize(frames);
    std::erase_if(table.points, [&](const TrackPoint& point) { return point.frame >= frames; });
  }
  const std::string why = "one column a time stamp";
  const auto linear = checked_columns(file.read("v_vk_vk_i"), 3, frames, why);
  const auto angular = checked_columns(file.read("w_vk_vk_i"), 3, frames, why);
  for (std::size_t k = 0; k < frames; ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    recording.velocities.push_back(
        {.time = times[k], .linear_imu = linear.col(column), .angular_imu = angular.col(column)});
  }
  recording.frames = make_frames(table, times, StalePixels::kKeep, recording.remarks);
  read_stated_noise(file, recording);
  read_truth(file, times, recording);
  read_true_landmarks(file, table.tracks, recording);
  return recording;
}

}  // namespace chasles
