#pragma once

#include <filesystem>
#include <string_view>

#include <chasles/data/recording.hpp>

namespace chasles {

// Every reader throws InputError that names file, field, index, what was found, what was expected.

/// Reads a recording of any known kind: an ECE276A .npz, a STARS .mat, an EuRoC folder, IMU
/// table or table of tracks, a folder of AprilGrid tracks, a drive of KITTI's raw data, a ROS 1
/// bag, a folder of images, or one of the project's own format. The kind is told by content, not by
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

/// An EuRoC recording of images and IMU samples as the ASL writes it: a folder with mav0/, or that
/// folder itself: camN/sensor.yaml, camN/data.csv, camN/data/, imu0/sensor.yaml, imu0/data.csv, and
/// where known state_groundtruth_estimate0/data.csv, or in its place truth.tum beside mav0. All
/// cameras are kept.
Recording read_euroc_asl_recording(const std::filesystem::path& folder);
/// Whether a folder looks like one.
bool is_euroc_asl_folder(const std::filesystem::path& folder);

/// Tracks of an EuRoC recording's cam0: a table `#timestamp [ns],track_id,u,v`, plain or
/// compressed, named SEQUENCE_klt_tracks_cam0.csv, with the samples SEQUENCE_imu.csv and, where
/// known, the truth beside it. cam0_sensor.yaml beside it is the camera; without it that of all
/// EuRoC's recordings.
Recording read_klt_tracks_recording(const std::filesystem::path& file);
/// Whether a file's first bytes are those of such a table.
bool begins_klt_tracks(std::string_view bytes);

/// A folder of images (docs/formats.md): images/camN/ with times.csv or named by their times,
/// imu.csv, and calibration.yaml or Kalibr's two files; truth.tum where known.
Recording read_image_folder_recording(const std::filesystem::path& folder);

/// A drive of KITTI's raw data, synced and rectified (DATE_drive_NNNN_sync), with the calibration
/// of its day in the folder above and the unsynced samples, where they are, in the _extract folder
/// beside it.
Recording read_kitti_raw_recording(const std::filesystem::path& folder);
/// Whether a folder looks like one.
bool is_kitti_raw_folder(const std::filesystem::path& folder);

/// A ROS 1 bag with images and IMU samples, and Kalibr's calibration beside it. InputError where
/// the program was built without librosbag-storage.
Recording read_bag_recording(const std::filesystem::path& file);

/// The project's own folder (docs/formats.md).
Recording read_folder_recording(const std::filesystem::path& folder);
void write_folder_recording(const Recording& recording, const std::filesystem::path& folder);

/// TUM trajectories: `t tx ty tz qx qy qz qw`, seconds and metres, # comments. What is read may be
/// compressed with gzip.
Trajectory read_tum(const std::filesystem::path& file);
void write_tum(const Trajectory& trajectory, const std::filesystem::path& file);

}  // namespace chasles
