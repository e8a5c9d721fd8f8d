#include <algorithm>
#include <future>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/imu_noise.hpp>
#include <chasles/calibration/imu_range.hpp>
#include <chasles/calibration/lens.hpp>
#include <chasles/calibration/shutter.hpp>
#include <chasles/codec/image_encode.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/write_euroc.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMark = "# Written by chasles: is replaced when it is written again.\n";

bool is_ours(const fs::path& folder) {
  const fs::path body = folder / "mav0" / "body.yaml";
  std::error_code ignored;
  return fs::exists(body, ignored) && read_file(body).starts_with(kMark);
}

std::string yaml_motion(const SE3& T) {
  std::string text = "T_BS:\n  cols: 4\n  rows: 4\n  data: [";
  for (int i = 0; i < 3; ++i) {
    text += fmt::format("{}, {}, {}, {},\n         ", T.R(i, 0), T.R(i, 1), T.R(i, 2), T.p(i));
  }
  return text + "0.0, 0.0, 0.0, 1.0]\n";
}

std::string sensor_text(const char* type, const std::string& comment, const SE3& imu_T_sensor) {
  return fmt::format("sensor_type: {}\ncomment: {}\n\n# To the body's frame, the IMU's.\n{}\n",
                     type, comment, yaml_motion(imu_T_sensor));
}

// The rate from the median interval [Hz].
template <typename Times>
double rate_of(const Times& times) {
  std::vector<double> gaps;
  for (std::size_t i = 1; i < times.size(); ++i)
    gaps.push_back(to_seconds(times[i] - times[i - 1]));
  if (gaps.empty()) return 0;
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  return 1 / *middle;
}

std::string camera_text(const Camera& c, std::size_t number, double rate, bool exact) {
  // EuRoC's files of a pinhole have a model always, and a name of their own for this one.
  KalibrLens lens = kalibr_lens(c);
  const bool zeros = lens.distortion_model == "none" && lens.camera_model == "pinhole";
  if (zeros || lens.distortion_model == "radtan") lens.distortion_model = "radial-tangential";
  if (zeros) lens.coefficients.assign(4, 0);
  return sensor_text("camera", fmt::format("camera {}", number), c.cam_T_imu.inverse()) +
         fmt::format(
             "rate_hz: {:.6g}\nresolution: [{}, {}]\ncamera_model: {}\n"
             "intrinsics: [{}] # {}fu, fv, cu, cv\n"
             "distortion_model: {}\ndistortion_coefficients: [{}]\n",
             rate, c.width, c.height, lens.camera_model, fmt::join(lens.intrinsics, ", "),
             lens.camera_model == "pinhole" ? "" : "its own, ", lens.distortion_model,
             fmt::join(lens.coefficients, ", ")) +
         shutter_text(c.shutter, "") +
         (exact ? "# The images are rendered with this calibration.\ncalibration_is_exact: true\n"
                : "");
}

void write_samples(const Recording& recording, const fs::path& folder) {
  make_folder(folder);
  std::vector<Time> times;
  fmt::memory_buffer rows;
  fmt::format_to(std::back_inserter(rows),
                 "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
                 "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n");
  for (const ImuSample& s : recording.imu) {
    const Eigen::Vector3d &w = s.angular_rate_imu, &a = s.specific_force_imu;
    fmt::format_to(std::back_inserter(rows), "{},{},{},{},{},{},{}\n", s.time.count(), w.x(), w.y(),
                   w.z(), a.x(), a.y(), a.z());
    times.push_back(s.time);
  }
  write_file(folder / "data.csv", {rows.data(), rows.size()});
  const ImuNoise& noise = *recording.imu_noise;
  const std::string meaning =
      fmt::format("imu_convention {} (docs/formats.md)", name_of(recording.imu_convention));
  write_file(
      folder / "sensor.yaml",
      sensor_text("imu", meaning, {}) +
          fmt::format("rate_hz: {:.6g}\n"
                      "gyroscope_noise_density: {} # rad/s/sqrt(Hz)\n"
                      "gyroscope_random_walk: {} # rad/s^2/sqrt(Hz)\n"
                      "accelerometer_noise_density: {} # m/s^2/sqrt(Hz)\n"
                      "accelerometer_random_walk: {} # m/s^3/sqrt(Hz)\n",
                      rate_of(times), noise.gyroscope_noise_density, noise.gyroscope_random_walk,
                      noise.accelerometer_noise_density, noise.accelerometer_random_walk) +
          noise_is_exact_text(noise) + imu_range_text(recording.imu_range));
}

void write_states(const Recording& recording, const fs::path& folder) {
  make_folder(folder);
  fmt::memory_buffer rows;
  fmt::format_to(
      std::back_inserter(rows),
      "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], "
      "q_RS_z [], v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], "
      "b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], "
      "b_a_RS_S_z [m s^-2]\n");
  for (std::size_t i = 0; i < recording.truth.size(); ++i) {
    const StampedPose& row = recording.truth[i];
    const TrueMotion& motion = recording.true_motion[i];
    const Eigen::Vector4d q = unit_quaternion(row.pose.R);
    const Eigen::Vector3d &p = row.pose.p, &v = motion.v_world;
    const Eigen::Vector3d &g = motion.gyroscope_bias, &a = motion.accelerometer_bias;
    fmt::format_to(std::back_inserter(rows), "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n",
                   row.time.count(), p.x(), p.y(), p.z(), q[3], q[0], q[1], q[2], v.x(), v.y(),
                   v.z(), g.x(), g.y(), g.z(), a.x(), a.y(), a.z());
  }
  write_file(folder / "data.csv", {rows.data(), rows.size()});
  write_file(folder / "sensor.yaml", sensor_text("visual-inertial", "the true motion", {}));
}

void write_truth(const Recording& recording, const fs::path& folder) {
  if (recording.truth.empty()) return;
  if (recording.true_motion.size() == recording.truth.size()) {
    write_states(recording, folder / "mav0" / "state_groundtruth_estimate0");
  } else {
    write_tum(recording.truth, folder / "truth.tum");
  }
}

void check(const Recording& r) {
  const auto need = [&](bool there, const char* what) {
    if (there) return;
    throw UsageError(
        fmt::format("{}: the recording has no {}, which an EuRoC folder needs; "
                    "expected images, cameras, IMU samples and their noise densities",
                    r.name, what));
  };
  need(r.images != nullptr && r.images->size() > 0, "images");
  need(!r.cameras.empty(), "cameras");
  need(!r.imu.empty(), "IMU samples");
  need(r.imu_noise.has_value(), "noise densities of the IMU");
}

void check_images(const Recording& r, const ImageFrame& frame) {
  bool fit = frame.images.size() == r.cameras.size();
  for (std::size_t c = 0; fit && c < r.cameras.size(); ++c) {
    const GrayImage& image = frame.images[c];
    const auto pixels = static_cast<std::size_t>(image.width) * image.height;
    fit = image.empty() || (image.width == r.cameras[c].width &&
                            image.height == r.cameras[c].height && image.pixels.size() == pixels);
  }
  if (fit) return;
  throw UsageError(fmt::format(
      "{}: the images at {} ns do not fit the cameras; expected {}, each of its camera's size",
      r.name, frame.time.count(), r.cameras.size()));
}

using Lists = std::vector<std::string>;  // of images, one a camera

// Writes the images of one frame, and their lines.
Lists write_frame(const Recording& r, std::size_t i, const fs::path& sensors) {
  const ImageFrame frame = r.images->read(i);
  check_images(r, frame);
  Lists lines(r.cameras.size());
  for (std::size_t c = 0; c < r.cameras.size(); ++c) {
    if (frame.images[c].empty()) continue;
    const std::string name = fmt::format("{}.png", frame.time.count());
    write_file(sensors / fmt::format("cam{}", c) / "data" / name, png_bytes(frame.images[c]));
    lines[c] = fmt::format("{},{}\n", frame.time.count(), name);
  }
  return lines;
}

// Writes the frames [begin, end), each on a thread, the first on this one.
void write_frames(const Recording& r, std::size_t begin, std::size_t end, const fs::path& sensors,
                  Lists& lists) {
  std::vector<std::future<Lists>> others;
  for (std::size_t i = begin + 1; i < end; ++i) {
    others.push_back(std::async(std::launch::async, [&, i] { return write_frame(r, i, sensors); }));
  }
  const auto add = [&](const Lists& lines) {
    for (std::size_t c = 0; c < lists.size(); ++c) lists[c] += lines[c];
  };
  add(write_frame(r, begin, sensors));
  for (std::future<Lists>& other : others) add(other.get());
}

void write_calibrations(const Recording& r, const fs::path& sensors) {
  std::vector<Time> times;
  for (std::size_t i = 0; i < r.images->size(); ++i) times.push_back(r.images->time(i));
  for (std::size_t c = 0; c < r.cameras.size(); ++c) {
    const fs::path camera = sensors / fmt::format("cam{}", c);
    make_folder(camera / "data");
    write_file(camera / "sensor.yaml",
               camera_text(r.cameras[c], c, rate_of(times), r.exact_calibration));
  }
}

}  // namespace

void prepare_euroc_folder(const fs::path& folder) {
  make_folder(folder);
  std::error_code error;
  if (!fs::is_empty(folder, error) && !error && !is_ours(folder)) {
    throw UsageError(fmt::format(
        "{}: is not empty, and was not written by chasles as an EuRoC folder; expected a new or "
        "empty folder",
        folder.string()));
  }
  fs::remove_all(folder / "mav0", error);
  if (!error) fs::remove(folder / "truth.tum", error);
  if (!error) fs::remove(folder / "plan.csv", error);
  if (error) {
    throw UsageError(fmt::format("{}: an earlier recording cannot be removed: {}", folder.string(),
                                 error.message()));
  }
  make_folder(folder / "mav0");
  write_file(folder / "mav0" / "body.yaml", std::string(kMark) + "comment: simulated\n");
}

std::size_t write_euroc(const Recording& recording, const fs::path& folder,
                        const std::function<bool(std::size_t)>& done, int threads) {
  check(recording);
  prepare_euroc_folder(folder);
  const fs::path sensors = folder / "mav0";
  write_samples(recording, sensors / "imu0");
  write_truth(recording, folder);
  write_plan_of(recording.plan, folder);
  write_calibrations(recording, sensors);
  Lists lists(recording.cameras.size(), "#timestamp [ns],filename\n");
  const auto at_a_time = static_cast<std::size_t>(std::max(threads, 1));
  std::size_t frames = 0;
  while (frames < recording.images->size()) {
    const std::size_t end = std::min(frames + at_a_time, recording.images->size());
    write_frames(recording, frames, end, sensors, lists);
    frames = end;
    if (done && !done(frames)) break;
  }
  for (std::size_t c = 0; c < lists.size(); ++c) {
    write_file(sensors / fmt::format("cam{}", c) / "data.csv", lists[c]);
  }
  return frames;
}

}  // namespace chasles
