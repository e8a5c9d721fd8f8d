#include <optional>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/npz_archive.hpp>
#include <chasles/recording/extrinsics.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/tracks.hpp>

namespace chasles {
namespace {

// Every known file uses the second interpretation. Little evidence for it is enough, and only
// strong evidence counts against it.
constexpr int kEnoughSteps = 20;
constexpr double kSigmasInFavour = 2;
constexpr double kSigmasAgainst = 5;

// The name of a field in the archive: the first of the alternatives that it has, else the first,
// which the reader then reports as missing.
std::string present(const NpzArchive& archive, const std::vector<std::string>& alternatives) {
  for (const std::string& name : alternatives) {
    if (archive.has(name)) return name;
  }
  return alternatives.front();
}

StereoRig read_rig(const NpzArchive& archive) {
  const std::string where = archive.where("K");
  const Eigen::MatrixXd K = checked_matrix(archive.read("K"), 3, 3, "the pinhole matrix");
  const bool pinhole = K(0, 1) == 0 && K(1, 0) == 0 && K(2, 0) == 0 && K(2, 1) == 0 && K(2, 2) == 1;
  if (!pinhole) {
    throw InputError(fmt::format(
        "{}: is [{} {} {}; {} {} {}; {} {} {}], expected a pinhole matrix [fx 0 cx; 0 fy cy; 0 0 "
        "1]",
        where, K(0, 0), K(0, 1), K(0, 2), K(1, 0), K(1, 1), K(1, 2), K(2, 0), K(2, 1), K(2, 2)));
  }
  return {.fx = checked_positive(where + ": focal length fx", K(0, 0)),
          .fy = checked_positive(where + ": focal length fy", K(1, 1)),
          .cx = K(0, 2),
          .cy = K(1, 2),
          .baseline = checked_positive(archive.where("b") + ": the baseline",
                                       checked_scalar(archive.read("b"))),
          .cam0_T_imu = {}};
}

std::vector<BodyVelocity> read_velocities(const NpzArchive& archive,
                                          const std::vector<Time>& times) {
  const std::string angular_name = present(archive, {"rotational_velocity", "angular_velocity"});
  const std::string why = "one column a time stamp";
  const auto linear = checked_matrix(archive.read("linear_velocity"), 3, times.size(), why);
  const auto angular = checked_matrix(archive.read(angular_name), 3, times.size(), why);
  std::vector<BodyVelocity> velocities(times.size());
  for (std::size_t k = 0; k < times.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    velocities[k] = {
        .time = times[k], .linear_imu = linear.col(column), .angular_imu = angular.col(column)};
  }
  return velocities;
}

TrackTable read_tracks(const NpzArchive& archive, std::size_t frames) {
  using Order = TrackCollector::Order;
  std::optional<TrackCollector> collector;
  const std::string where = archive.where("features");
  archive.stream(
      "features",
      [&](const NpyHeader& header) {
        const auto& shape = header.shape;
        if (shape.size() != 3 || shape[0] != 4 || shape[2] != frames) {
          throw InputError(fmt::format(
              "{}: has shape {}, expected (4, M, {}): four pixels of M landmarks at {} time stamps",
              where, shape_text(shape), frames, frames));
        }
        collector.emplace(shape[1], frames,
                          header.fortran_order ? Order::kFrameTrackPixel : Order::kPixelTrackFrame,
                          where);
      },
      [&](std::span<const double> values) { collector->add(values); });
  return std::move(*collector).finish();
}

/// An interpretation of the file's numbers for the camera's pose on the body.
struct Reading {
  std::string formula;
  SE3 cam0_T_imu;
};

// cam_T_imu as printed, and as every known archive means it (data/README.md, trap 1); imu_T_cam
// interpreted as its inverse, and as printed.
std::pair<Reading, Reading> readings(const std::string& field, const std::string& where,
                                     const Eigen::Matrix4d& M) {
  const SE3 printed = checked_motion(where, M);
  if (field == "cam_T_imu") {
    return {{.formula = "[C | rho]", .cam0_T_imu = printed},
            {.formula = "[C | -C rho]", .cam0_T_imu = {printed.R, -(printed.R * printed.p)}}};
  }
  return {{.formula = "cam_T_imu", .cam0_T_imu = printed},
          {.formula = "imu_T_cam", .cam0_T_imu = printed.inverse()}};
}

// Takes the matrix as recorded, or the interpretation that agrees with the data. Adds a remark.
void read_extrinsics(const NpzArchive& archive, ArchiveExtrinsics choice, Recording& recording) {
  const std::string field = present(archive, {"cam_T_imu", "imu_T_cam"});
  const Eigen::Matrix4d M =
      checked_matrix(archive.read(field), 4, 4, "a rigid motion [R p; 0 0 0 1]");
  const auto [first, second] = readings(field, archive.where(field), M);
  if (choice == ArchiveExtrinsics::kRecorded) {
    recording.rig.cam0_T_imu = field == "cam_T_imu" ? first.cam0_T_imu : second.cam0_T_imu;
    recording.remarks.push_back(fmt::format("{} is taken as recorded", field));
    return;
  }
  const ExtrinsicVerdict verdict =
      compare_extrinsics(recording, first.cam0_T_imu, second.cam0_T_imu);
  const bool enough = verdict.steps >= kEnoughSteps;
  const bool take_second = !(enough && verdict.sigmas <= -kSigmasAgainst);
  const bool decided = enough && (!take_second || verdict.sigmas >= kSigmasInFavour);
  const Reading& taken = take_second ? second : first;
  const Reading& left = take_second ? first : second;
  recording.rig.cam0_T_imu = taken.cam0_T_imu;
  if (taken.formula == field) return;
  recording.remarks.push_back(fmt::format(
      "{} is taken as {}, not as {}{}: over {} steps in turns the mean reprojection cost is {:.2f} "
      "instead of {:.2f} ({:.1f} sigmas)",
      field, taken.formula, left.formula,
      decided ? "" : ", as in every known file of this kind, because these data do not decide",
      verdict.steps, take_second ? verdict.second_cost : verdict.first_cost,
      take_second ? verdict.first_cost : verdict.second_cost,
      take_second ? verdict.sigmas : -verdict.sigmas));
}

}  // namespace

Recording read_npz_recording(const std::filesystem::path& file, const ReaderSettings& settings) {
  const NpzArchive archive(file);
  Recording recording;
  recording.name = file.stem().string();
  const std::vector<Time> times = checked_times(archive.read("time_stamps"));
  recording.rig = read_rig(archive);
  recording.velocities = read_velocities(archive, times);
  recording.frames = make_frames(read_tracks(archive, times.size()), times, settings.stale_pixels,
                                 recording.remarks);
  read_extrinsics(archive, settings.extrinsics, recording);
  return recording;
}

}  // namespace chasles
