#pragma once

#include <filesystem>
#include <string_view>

#include <chasles/recording/reader_settings.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

// Every reader throws InputError with file, field, index, the value found and the value expected.

/// Reads a recording of any supported kind: an ECE276A .npz, a STARS .mat, an EuRoC folder, IMU
/// table or table of tracks, a folder of AprilGrid tracks, a KITTI raw recording, a bag of ROS 1
/// or 2, a folder of images, a video, or the project's own format. The content determines the kind,
/// not the name. `settings` apply to ECE276A archives, and its number of cameras to recordings of
/// images.
Recording read_recording(const std::filesystem::path& path, const ReaderSettings& settings = {});

/// The ECE276A (UCSD) archive: body velocities and stereo tracks of a KITTI recording.
Recording read_npz_recording(const std::filesystem::path& file,
                             const ReaderSettings& settings = {});

/// The STARS Laboratory's and Barfoot's .mat files: body velocities, stereo tracks and truth.
Recording read_mat_recording(const std::filesystem::path& file);

/// IMU samples and stereo tracks of an AprilGrid's corners, from EuRoC's calibration recording. The
/// folder has tracks.csv, imu0.csv, camN_sensor.yaml, imu0_sensor.yaml and, where known, the truth:
/// gt_pnp.csv and landmarks.csv. The tables may be compressed (.csv.gz). The truth's world is the
/// board's frame, rotated so that z points up (fit_gravity).
Recording read_april_recording(const std::filesystem::path& folder);

/// An EuRoC IMU table NAME_imu.csv with the truth beside it: NAME_gt.csv (states) or NAME_gt.txt
/// (TUM, poses only). Each may be compressed (.gz). The recording has no frames.
Recording read_euroc_imu_recording(const std::filesystem::path& file);

/// An EuRoC recording of images and IMU samples in the ASL format: a folder that contains mav0/, or
/// mav0/ itself. It has camN/sensor.yaml, camN/data.csv, camN/data/, imu0/sensor.yaml,
/// imu0/data.csv and, where known, state_groundtruth_estimate0/data.csv, or truth.tum beside mav0
/// instead. Without sensor.yaml, Kalibr's files beside mav0 or in dso/ (TUM-VI) calibrate it, and
/// mocap0/data.csv may be the truth. The first `cameras` cameras are read.
Recording read_euroc_asl_recording(const std::filesystem::path& folder,
                                   std::size_t cameras = kAllCameras);
/// Whether the files in a folder are those of such a recording.
bool is_euroc_asl_folder(const std::filesystem::path& folder);

/// Feature tracks of an EuRoC recording's cam0: a table `#timestamp [ns],track_id,u,v`, plain or
/// compressed, named SEQUENCE_klt_tracks_cam0.csv, with the samples SEQUENCE_imu.csv and, where
/// known, the truth beside it. cam0_sensor.yaml beside it calibrates the camera; without it the
/// reader uses the calibration of all EuRoC recordings.
Recording read_klt_tracks_recording(const std::filesystem::path& file);
/// Whether a file's first bytes are those of such a table.
bool begins_klt_tracks(std::string_view bytes);

/// A folder of images (docs/formats.md): images/camN/ (or camN/, image_N/) with their times
/// (image_times.hpp), or UZH-FPV's lists; a table of an IMU (find_imu_table()); calibration.yaml,
/// Kalibr's two files or another program's (foreign_calibration.hpp) and, where known, truth.tum.
/// The first `cameras` cameras are read.
Recording read_image_folder_recording(const std::filesystem::path& folder,
                                      std::size_t cameras = kAllCameras);
/// Whether the files in a folder are those of such a recording.
bool is_image_folder(const std::filesystem::path& folder);

/// A video (MP4, QuickTime), or a folder with one: H.264, H.265 or Motion JPEG, at the times that
/// the file states or that a list beside it has. The samples of the IMU are a table beside it
/// (docs/videos.md). Its calibration is beside it as NAME.yaml or as that of a folder of images, or
/// above the folder. A mask and the truth are beside it, where known.
Recording read_video_recording(const std::filesystem::path& path);
/// Whether the files in a folder are those of such a recording.
bool is_video_folder(const std::filesystem::path& folder);

/// A KITTI raw recording, synced and rectified (DATE_drive_NNNN_sync). The calibration of its day
/// is in the parent folder; the unsynced samples, where available, in the _extract folder beside
/// it.
Recording read_kitti_raw_recording(const std::filesystem::path& folder,
                                   std::size_t cameras = kAllCameras);
/// Whether the files in a folder are those of such a recording.
bool is_kitti_raw_folder(const std::filesystem::path& folder);

/// A sequence of KITTI odometry (image_0, image_1, calib.txt, times.txt) with inertial data that
/// are not KITTI's beside it: imu.csv, imu.yaml (docs/formats.md) and, where known, truth.tum. The
/// first `cameras` cameras are read. Throws InputError with what is missing.
Recording read_kitti_odometry_recording(const std::filesystem::path& folder,
                                        std::size_t cameras = kAllCameras);
/// Whether the files in a folder are those of such a sequence.
bool is_kitti_odometry_folder(const std::filesystem::path& folder);

/// A bag of ROS 1 (.bag) or ROS 2 (.db3, .mcap) with images and IMU samples: a file, or a folder
/// with the files of one recording. Kalibr's calibration is beside it, or the bag has CameraInfo
/// and /tf_static, and imu.yaml is beside it. The first `cameras` cameras are read.
Recording read_bag_recording(const std::filesystem::path& path, std::size_t cameras = kAllCameras);

/// The project's own folder (docs/formats.md).
Recording read_folder_recording(const std::filesystem::path& folder);
void write_folder_recording(const Recording& recording, const std::filesystem::path& folder);

/// Trajectories. read_tum() reads TUM's lines `t tx ty tz qx qy qz qw` (seconds and metres, #
/// comments), between blanks or commas, and tables whose first line names other columns, as EuRoC's
/// state_groundtruth_estimate0, vicon0 and mocap0; the last two are moved to the IMU by a T_BS in
/// sensor.yaml beside them. Times may be milli-, micro- or nanoseconds. Also gzip-compressed.
/// Throws InputError for a row that is not a pose, and for times that do not rise strictly.
Trajectory read_tum(const std::filesystem::path& file);
/// The same for a table as motion capture and scripts write it: rows without a pose (NaN, or a
/// quaternion of zeros) and repeated times are left out, and rows are sorted by time, with remarks.
Trajectory read_tum(const std::filesystem::path& file, std::vector<std::string>& remarks);
void write_tum(const Trajectory& trajectory, const std::filesystem::path& file);

}  // namespace chasles
