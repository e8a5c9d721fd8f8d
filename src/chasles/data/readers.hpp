#pragma once

#include <filesystem>

#include <chasles/data/recording.hpp>

namespace chasles {

// Every reader throws InputError that names file, field, index, what was found, what was expected.

/// Reads a recording of any known kind: an ECE276A .npz, a STARS .mat, an EuRoC IMU table, a folder
/// of AprilGrid tracks, or one of the project's own format. The kind is told by content, not by
/// name.
Recording read_recording(const std::filesystem::path& path);

/// The ECE276A (UCSD) archive: body velocities and stereo tracks of a KITTI drive.
Recording read_npz_recording(const std::filesystem::path& file);

/// The STARS Laboratory's and Barfoot's .mat files: body velocities, stereo tracks and truth.
Recording read_mat_recording(const std::filesystem::path& file);

/// IMU samples and stereo tracks of an AprilGrid's corners, from EuRoC's calibration recording: a
/// folder with tracks.csv, imu0.csv, camN_sensor.yaml and imu0_sensor.yaml, and where known with
/// the truth, gt_pnp.csv and landmarks.csv. The tables may be compressed (.csv.gz). The truth's
/// world is the board's frame, turned so that z points up (fit_gravity).
Recording read_april_recording(const std::filesystem::path& folder);

/// An EuRoC IMU table NAME_imu.csv with the truth beside it, NAME_gt.csv (states) or NAME_gt.txt
/// (TUM: poses only); each may be compressed (.gz). No frames.
Recording read_euroc_imu_recording(const std::filesystem::path& file);

/// The project's own folder (docs/formats.md).
Recording read_folder_recording(const std::filesystem::path& folder);
void write_folder_recording(const Recording& recording, const std::filesystem::path& folder);

/// TUM trajectories: `t tx ty tz qx qy qz qw`, seconds and metres, # comments. What is read may be
/// compressed with gzip.
Trajectory read_tum(const std::filesystem::path& file);
void write_tum(const Trajectory& trajectory, const std::filesystem::path& file);

}  // namespace chasles
