#include <chasles/bags/bag_testing.hpp>
#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/calibration/kalibr.hpp>
#include <chasles/recording/readers.hpp>

#include "kinds.hpp"
#include "parts.hpp"
#include "use_recording.hpp"

namespace chasles::fuzz {
namespace {

namespace fs = std::filesystem;

std::string euroc_seed(const fs::path& scratch) {
  test::write_euroc_folder(scratch / "euroc", 1);
  return pack(parts_of(scratch / "euroc"));
}

void read_euroc(const fs::path& scratch, std::string_view bytes) {
  lay_out(scratch / "input", bytes);
  use(read_euroc_asl_recording(scratch / "input"));
}

std::string kalibr_seed(const fs::path&) {
  const std::string scales = "[[1.1, 0, 0], [0.01, 0.9, 0], [0, 0.02, 1]]\n";
  return pack({{"camchain-imucam.yaml", test::kalibr_chain() + "  timeshift_cam_imu: 0.001\n"},
               {"imu.yaml", std::string(test::kKalibrImu) + "accelerometers:\n  M: " + scales +
                                "gyroscopes:\n  M: " + scales +
                                "  A: [[1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-3]]\n"}});
}

void read_kalibr_parts(const fs::path& scratch, std::string_view bytes) {
  lay_out(scratch / "input", bytes);
  if (const auto files = find_kalibr(scratch / "input")) read_kalibr(*files);
}

// One settings file of ORB-SLAM3 and one calibration of Basalt, in two places.
std::string foreign_seed(const fs::path&) {
  const std::string place = R"({"px":0,"py":0,"pz":0,"qx":0,"qy":0,"qz":0,"qw":1})",
                    eye = "[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n";
  return pack(
      {{"walk.yaml",
        "%YAML:1.0\nCamera.type: \"PinHole\"\nCamera1.fx: 4\nCamera1.fy: 4\nCamera1.cx: 3\n"
        "Camera1.cy: 2\nCamera.width: 8\nCamera.height: 6\nIMU.T_b_c1: !!opencv-matrix\n"
        "   rows: 4\n   cols: 4\n   data: " +
            eye +
            "IMU.NoiseGyro: 1e-4\nIMU.NoiseAcc: 2e-3\nIMU.GyroWalk: 1e-5\nIMU.AccWalk: 3e-3\n"},
       {"config/calibration.json",
        R"({"value0":{"T_imu_cam":[)" + place +
            R"(],"intrinsics":[{"camera_type":"pinhole","intrinsics":{"fx":4,"fy":4,"cx":3,"cy":2}}],)"
            R"("resolution":[[8,6]],"accel_noise_std":0.1,"gyro_noise_std":0.1,)"
            R"("accel_bias_std":0.1,"gyro_bias_std":0.1}})"}});
}

void read_foreign_parts(const fs::path& scratch, std::string_view bytes) {
  lay_out(scratch / "input", bytes);
  find_calibration({scratch / "input" / "config"});
  find_calibration({scratch / "input"});
}

std::string images_seed(const fs::path&) {
  return pack({{"calibration.yaml",
                "format: chasles-recording-1\nname: walk\ncameras:\n  - resolution: [8, 6]\n"
                "    intrinsics: [4, 4, 3.5, 2.5]\n    distortion_model: none\n    cam_T_imu:\n"
                "      - [1, 0, 0, 0]\n      - [0, 1, 0, 0]\n      - [0, 0, 1, 0]\n"
                "      - [0, 0, 0, 1]\nimu_convention: interval-mean\n"},
               {"imu.csv", "time_ns,wx,wy,wz,ax,ay,az\n" + test::five_samples()},
               {"images/cam0/times.csv", "time_ns,file\n5000000,a.png\n10000000,b.png\n"},
               {"images/cam0/a.png", test::picture_bytes(10)},
               {"images/cam0/b.png", test::picture_bytes(20)},
               {"truth.tum", "# t tx ty tz qx qy qz qw\n0.005 1 2 3 0 0 0 1\n"}});
}

void read_images(const fs::path& scratch, std::string_view bytes) {
  lay_out(scratch / "input", bytes);
  use(read_image_folder_recording(scratch / "input"));
}

std::string kitti_packets(const std::string& drive, Parts& parts) {
  const std::string packet =
      "49 8.4 110 0 0 0.1 0 0 0 0 0 1 2 9.5 3 4 5 0.1 0.2 0.3 6 7 8 0.05 0.01 4 11 6 6 6\n";
  for (const char* file : {"0000000000", "0000000001"}) {
    parts.emplace_back(drive + "/oxts/data/" + file + ".txt", packet);
  }
  const std::string times = "2011-09-26 13:02:25.900000000\n2011-09-26 13:02:26.000000000\n";
  parts.emplace_back(drive + "/oxts/timestamps.txt", times);
  return times;
}

std::string kitti_seed(const fs::path&) {
  Parts parts{{"calib_imu_to_velo.txt", "R: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n"},
              {"calib_velo_to_cam.txt", "R: 0 -1 0 0 0 -1 1 0 0\nT: 0 -0.1 -0.3\n"},
              {"calib_cam_to_cam.txt",
               "S_rect_00: 8 6\nR_rect_00: 1 0 0 0 1 0 0 0 1\n"
               "P_rect_00: 4 0 3.5 0 0 4 2.5 0 0 0 1 0\n"}};
  const std::string times = kitti_packets("a_sync", parts);
  kitti_packets("a_extract", parts);
  parts.emplace_back("a_sync/image_00/timestamps.txt", times);
  parts.emplace_back("a_sync/image_00/data/0000000000.png", test::picture_bytes(10));
  parts.emplace_back("a_sync/image_00/data/0000000001.png", test::picture_bytes(20));
  return pack(parts);
}

void read_kitti(const fs::path& scratch, std::string_view bytes) {
  lay_out(scratch / "input", bytes);
  use(read_kitti_raw_recording(scratch / "input" / "a_sync"));
}

std::string odometry_seed(const fs::path&) {
  return pack(
      {{"calib.txt", "P0: 4 0 3.5 0 0 4 2.5 0 0 0 1 0\n"},
       {"times.txt", "0.005\n\n1.5e-2\n"},
       {"imu.csv", "timestamp [ns],wx,wy,wz,ax,ay,az\n" + test::five_samples()},
       {"imu.yaml", std::string(test::kKalibrImu) +
                        "T_cam_imu: !!opencv-matrix\n  rows: 4\n  cols: 4\n  data: [0, -1, 0, "
                        "0.1, 0, 0, -1, 0.2, 1, 0, 0, 0.3, 0, 0, 0, 1]\n"
                        "timeshift_cam_imu: 0.001\n"},
       {"image_0/000000.png", test::picture_bytes(10)},
       {"image_0/000002.png", test::picture_bytes(20)}});
}

void read_odometry(const fs::path& scratch, std::string_view bytes) {
  lay_out(scratch / "input", bytes);
  use(read_kitti_odometry_recording(scratch / "input"));
}

}  // namespace

std::vector<Kind> image_folder_kinds() {
  return {
      {"euroc", euroc_seed, read_euroc},
      {"kalibr", kalibr_seed, read_kalibr_parts},
      {"foreign", foreign_seed, read_foreign_parts},
      {"images", images_seed, read_images},
      {"kitti", kitti_seed, read_kitti},
      {"odometry", odometry_seed, read_odometry},
  };
}

}  // namespace chasles::fuzz
