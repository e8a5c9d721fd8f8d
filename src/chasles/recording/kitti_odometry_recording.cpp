#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/calibration/kalibr.hpp>
#include <chasles/calibration/kitti_calibration.hpp>
#include <chasles/codec/folder_names.hpp>
#include <chasles/codec/image_decode.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/yaml_map.hpp>
#include <chasles/recording/apply_calibration.hpp>
#include <chasles/recording/image_recording.hpp>
#include <chasles/recording/imu_table.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/truth_table.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// The numbers of the grey cameras or, without them, of the colour cameras.
std::vector<int> odometry_cameras(const fs::path& folder) {
  std::vector<int> numbers;
  std::error_code ignored;
  for (const int first : {0, 2}) {
    for (int n = first; n < first + 2 && numbers.size() < 2; ++n) {
      if (fs::is_directory(folder / fmt::format("image_{}", n), ignored)) numbers.push_back(n);
    }
    if (!numbers.empty()) break;
  }
  return numbers;
}

// One time in seconds a line; an empty line stands for an image that was lost.
std::vector<std::optional<Time>> read_times(const fs::path& file) {
  const std::string bytes = read_text(file);
  std::string_view rest = bytes;
  std::vector<std::optional<Time>> times;
  while (!rest.empty()) {
    const std::string_view text = trimmed(take_line(rest));
    const std::string where = fmt::format("{}:{}", file.string(), times.size() + 1);
    times.push_back(text.empty() ? std::nullopt : std::optional(parse_seconds(where, text)));
  }
  return times;
}

// The images NNNNNN.png at the times of their lines.
CameraFiles list_odometry_images(const fs::path& camera,
                                 const std::vector<std::optional<Time>>& times,
                                 std::vector<std::string>& remarks) {
  CameraFiles files{.folder = camera, .images = {}};
  std::size_t all = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(camera)) {
    const std::string name = entry.path().filename().string(), stem = entry.path().stem().string();
    if (!is_image_name(name)) continue;
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), index);
    if (error != std::errc() || end != stem.data() + stem.size()) continue;
    ++all;
    if (index < times.size() && times[index]) {
      files.images.push_back({.time = *times[index], .file = name});
    }
  }
  if (files.images.empty()) {
    throw InputError(fmt::format("{}: holds no image 000000.png, ..., with a line in times.txt",
                                 camera.string()));
  }
  const auto stated = static_cast<std::size_t>(
      std::ranges::count_if(times, [](const auto& time) { return time.has_value(); }));
  if (files.images.size() < all || files.images.size() < stated) {
    remarks.push_back(
        fmt::format("{} has {} images, and times.txt {} times: {} images have one, the others are "
                    "left out",
                    camera.filename().string(), all, stated, files.images.size()));
  }
  // Of two files of one line (000000.jpg, 000000.png) the reader takes the first.
  std::ranges::sort(files.images, [](const StampedFile& a, const StampedFile& b) {
    return std::tie(a.time, a.file) < std::tie(b.time, b.file);
  });
  return files;
}

// Images that were scaled down have the centre of the calibration near or beyond their edge.
void check_centre(const KittiProjection& P, const ImageSize& size, const std::string& where) {
  const auto central = [](double c, int length) { return c > 0.2 * length && c < 0.8 * length; };
  if (central(P.cx, size.width) && central(P.cy, size.height)) return;
  throw InputError(fmt::format(
      "{}: the principal point ({:.1f}, {:.1f}) is not near the centre of the images, which have "
      "{} x {} pixels, expected the calibration of images of this size",
      where, P.cx, P.cy, size.width, size.height));
}

// Its file states no size: that is the first image's.
Camera odometry_camera(const KittiCalibration& calibration, int number, const fs::path& image,
                       const SE3& cam0_T_imu) {
  const KittiProjection P = kitti_projection(calibration, fmt::format("P{}", number));
  const ImageSize size = stated_size(read_file(image), image.string());
  check_centre(P, size, fmt::format("calib.txt: P{}", number));
  return {.width = size.width,
          .height = size.height,
          .fx = P.fx,
          .fy = P.fy,
          .cx = P.cx,
          .cy = P.cy,
          .cam_T_imu = SE3{Eigen::Matrix3d::Identity(), P.t} * cam0_T_imu};
}

void check_inertial_data(const fs::path& folder, const std::optional<fs::path>& samples) {
  const bool calibration = fs::exists(folder / "imu.yaml");
  if (samples && calibration) return;
  const std::string found =
      samples ? fmt::format("with the samples of an IMU in {}, whose calibration is missing",
                            samples->filename().string())
              : "images without inertial data, which a run needs";
  throw InputError(fmt::format(
      "{}: is a sequence of KITTI odometry: {}. Put {}beside calib.txt: {}the four noise densities "
      "as Kalibr names them and T_cam_imu, from the IMU to the rectified left grey "
      "camera (docs/formats.md). KITTI's raw drives have inertial data",
      folder.string(), found,
      samples       ? "imu.yaml "
      : calibration ? "imu.csv "
                    : "both ",
      samples ? "" : "imu.csv with the columns time_ns,wx,wy,wz,ax,ay,az, and imu.yaml with "));
}

// Whether Kalibr's or another program's files calibrate the cameras, in place of T_cam_imu.
bool has_own_calibration(const fs::path& folder) {
  const fs::path imu = folder / "imu.yaml";
  if (fs::exists(imu) && YamlMap::read(imu, {}).has("T_cam_imu")) return false;
  return find_calibration({folder}).has_value();
}

}  // namespace

bool is_kitti_odometry_folder(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / "calib.txt", ignored) && fs::exists(folder / "times.txt", ignored) &&
         !odometry_cameras(folder).empty();
}

Recording read_kitti_odometry_recording(const fs::path& folder, std::size_t cameras) {
  if (has_own_calibration(folder)) return read_image_folder_recording(folder, cameras);
  Recording recording;
  const std::optional<fs::path> table = find_imu_table(folder, recording.remarks);
  check_inertial_data(folder, table);
  recording.name = folder_name(folder);
  const YamlMap map = YamlMap::read(folder / "imu.yaml", {.known = {}, .needed = {"T_cam_imu"}});
  const KalibrCalibration imu = read_kalibr_imu(folder / "imu.yaml");
  take_kalibr(imu, recording);
  const std::vector<std::optional<Time>> times = read_times(folder / "times.txt");
  const KittiCalibration calibration(folder / "calib.txt");
  std::vector<std::optional<CameraFiles>> images;
  const std::vector<int> numbers = odometry_cameras(folder);
  if (numbers.empty()) {
    throw InputError(
        fmt::format("{}: has no folder of images, expected image_0 or image_2", folder.string()));
  }
  for (const int number : numbers) {
    if (images.size() == cameras) break;
    images.emplace_back(
        list_odometry_images(folder / fmt::format("image_{}", number), times, recording.remarks));
    const fs::path first = images.back()->folder / images.back()->images.front().file;
    recording.cameras.push_back(
        odometry_camera(calibration, number, first, map.motion("T_cam_imu")));
  }
  recording.imu = read_imu_table(*table, recording.remarks);
  tidy_samples(*table, recording);
  if (imu.imu_intrinsics) correct_samples(*imu.imu_intrinsics, recording);
  const std::vector<Time> offsets(images.size(), read_time_offset(map));
  remark_on_time_offsets(offsets, recording.remarks);
  open_cameras(std::move(images), offsets, folder / "image_0", recording);
  const fs::path truth = folder / "truth.tum";
  if (fs::exists(truth)) read_truth_of_recording(truth, recording);
  remark_on_coverage(recording);
  return recording;
}

}  // namespace chasles
