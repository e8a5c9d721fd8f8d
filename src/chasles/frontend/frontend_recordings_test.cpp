#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include <chasles/base/opencv_codecs_testing.hpp>
#include <chasles/frontend/frontend_testing.hpp>

namespace chasles::test {
namespace {

namespace fs = std::filesystem;

GrayImage read_image(const fs::path& file) {
  const cv::Mat decoded = opencv_read(file, cv::IMREAD_GRAYSCALE);
  GrayImage image{.width = decoded.cols, .height = decoded.rows, .pixels = {}};
  image.pixels.assign(decoded.datastart, decoded.dataend);
  return image;
}

/// Rows of numbers; a row ends at the first non-number.
std::vector<std::vector<double>> read_csv(const fs::path& file) {
  std::vector<std::vector<double>> rows;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream cells(line);
    std::vector<double>& row = rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::atof(cell.c_str()));
  }
  return rows;
}

/// Seventeen seconds of EuRoC's MH_01_easy with images, IMU and truth.
class MachineHall : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto folder = euroc_folder();
    if (!folder) GTEST_SKIP() << "no recordings";
    root = *folder / "MH_01_easy_17s" / "mav0";
    for (const auto& entry : fs::directory_iterator(root / "cam0" / "data")) {
      times.push_back(std::stoll(entry.path().stem().string()));
    }
    std::sort(times.begin(), times.end());
    truth = read_csv(root / "state_groundtruth_estimate0" / "data.csv");
    imu = read_csv(root / "imu0" / "data.csv");
  }

  /// The true pose of the IMU at the time [ns]; rows are 5 ms apart.
  SE3 pose_at(std::int64_t time) const {
    const auto row =
        std::lower_bound(truth.begin(), truth.end(), static_cast<double>(time) - 2.5e6,
                         [](const std::vector<double>& r, double t) { return r[0] < t; });
    const std::vector<double>& r = row == truth.end() ? truth.back() : *row;
    return {Eigen::Quaterniond(r[4], r[5], r[6], r[7]).normalized().toRotationMatrix(),
            {r[1], r[2], r[3]}};
  }

  /// Integrated gyroscope between two frames, with or without its bias.
  RotationPrior gyroscope_between(std::int64_t last, std::int64_t now, bool biased) const {
    Eigen::Matrix3d last_R_now = Eigen::Matrix3d::Identity();
    const Eigen::Vector3d bias =
        biased ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(-0.003172, 0.021267, 0.078502);
    for (const std::vector<double>& r : imu) {
      if (r[0] < static_cast<double>(last) || r[0] >= static_cast<double>(now)) continue;
      last_R_now = last_R_now * so3::exp(0.005 * (Eigen::Vector3d(r[1], r[2], r[3]) - bias));
    }
    return {.now_R_last_imu = last_R_now.transpose(), .trusted = true};
  }

  ImageFrame frame_at(std::int64_t time, std::size_t cameras) const {
    ImageFrame frame{.time = Time(time), .images = {}};
    const std::string file = std::to_string(time) + ".png";
    for (std::size_t c = 0; c < cameras; ++c) {
      frame.images.push_back(read_image(root / ("cam" + std::to_string(c)) / "data" / file));
    }
    return frame;
  }

  fs::path root;
  std::vector<std::int64_t> times;
  std::vector<std::vector<double>> truth, imu;
};

/// A point from the pixels of camera 0 and the true poses, by least squares over their rays; with
/// the residual of the rays [rad] and the parallax [rad].
struct ViewedPoint {
  Eigen::Vector3d p_world;
  double worst_ray = 0, parallax = 0;
};

struct View {
  SE3 world_T_cam;
  Eigen::Vector3d ray;  ///< unit, camera axes
};

ViewedPoint intersect(const std::vector<View>& views) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const View& view : views) {
    const Eigen::Vector3d d = view.world_T_cam.R * view.ray;
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
    A += across;
    b += across * view.world_T_cam.p;
  }
  ViewedPoint point{.p_world = A.inverse() * b};
  const auto direction = [&](const View& v) -> Eigen::Vector3d {
    return (point.p_world - v.world_T_cam.p).normalized();
  };
  for (const View& view : views) {
    const double off = (view.world_T_cam.R * view.ray - direction(view)).norm();
    point.worst_ray = std::max(point.worst_ray, off);
    point.parallax = std::max(point.parallax, (direction(view) - direction(views[0])).norm());
  }
  return point;
}

TEST_F(MachineHall, StereoMatchesAgreeWithPointsFromCameraZeroAndTheTruth) {
  const std::vector<Camera> rig = euroc_rig();
  Frontend frontend({}, rig);
  struct Seen {
    std::vector<View> views;
    std::vector<std::pair<SE3, Eigen::Vector2d>> other;  // world_T_cam1 and pixel there
    std::vector<SE3> all_other;                          // world_T_cam1, matched or not
  };
  std::map<LandmarkId, Seen> seen;
  double tracked = 0, tried = 0, matched = 0, frames = 0;
  for (std::size_t k = 0; k < 100; ++k) {
    const RotationPrior prior =
        k > 0 ? gyroscope_between(times[k - 1], times[k], false) : RotationPrior{};
    const FeatureFrame features = frontend.process(frame_at(times[k], 2), prior);
    const SE3 world_T_imu = pose_at(times[k]);
    const FrontendReport& r = frontend.report();
    if (k > 0) {
      tracked += r.tracked;
      tried += r.stereo_tried;
      matched += r.stereo_matched;
      frames += 1;
    }
    for (const PixelObservation& o : features.pixels) {
      const Camera& camera = rig[static_cast<std::size_t>(o.camera)];
      const SE3 world_T_cam = world_T_imu * camera.cam_T_imu.inverse();
      Seen& of = seen[o.landmark];
      if (o.camera == 0) {
        of.views.push_back({world_T_cam, unproject(camera, o.pixel)->ray.normalized()});
        of.all_other.push_back(world_T_imu * rig[1].cam_T_imu.inverse());
      } else {
        of.other.emplace_back(world_T_cam, o.pixel);
      }
    }
  }
  double checked = 0, right = 0, depths = 0, visible = 0;
  std::vector<double> errors;
  for (const auto& [id, of] : seen) {
    if (of.views.size() < 10) continue;
    const ViewedPoint point = intersect(of.views);
    if (point.parallax < 0.03 || point.worst_ray > 4e-3) continue;
    depths += 1;
    for (const SE3& world_T_cam : of.all_other) {
      const auto expected = project(rig[1], world_T_cam.inverse() * point.p_world);
      if (expected && in_image(rig[1], expected->pixel, 15)) visible += 1;
    }
    for (const auto& [world_T_cam, pixel] : of.other) {
      const auto expected = project(rig[1], world_T_cam.inverse() * point.p_world);
      if (!expected) continue;
      checked += 1;
      errors.push_back((expected->pixel - pixel).norm());
      if (errors.back() < 4) right += 1;
    }
  }
  ASSERT_GT(checked, 1000);
  std::sort(errors.begin(), errors.end());
  RecordProperty("points", static_cast<int>(depths));
  RecordProperty("precision_permille", static_cast<int>(1000 * right / checked));
  std::cout << "tracked " << tracked / frames << ", matched " << matched / frames << " of "
            << tried / frames << "; " << checked << " matches of " << depths
            << " points checked, within 4 px: " << right / checked << ", of the visible "
            << right / visible << ", median " << errors[errors.size() / 2] << " px\n";
  EXPECT_GT(right, 0.97 * checked);
  EXPECT_LT(errors[errors.size() / 2], 1.0);
  EXPECT_GT(tracked / frames, 130);
  EXPECT_GT(matched / frames, 90);
}

TEST_F(MachineHall, TracksAgreeWithTheTruthEvenWithABiasedGyroscopeOrNone) {
  const Camera camera = euroc_rig()[0];
  for (const int kind : {0, 1, 2}) {  // gyroscope without bias, with bias, absent
    Frontend frontend({}, {camera});
    std::map<LandmarkId, Eigen::Vector3d> last;
    SE3 last_pose;
    double tracked = 0, age = 0, good = 0, all = 0;
    for (std::size_t k = 0; k < 80; ++k) {
      const std::size_t i = k + 100;
      const RotationPrior prior = k > 0 && kind < 2
                                      ? gyroscope_between(times[i - 1], times[i], kind == 1)
                                      : RotationPrior{};
      const FeatureFrame features = frontend.process(frame_at(times[i], 1), prior);
      tracked += k > 0 ? frontend.report().tracked / 79.0 : 0;
      age = frontend.report().mean_age;
      const SE3 pose = pose_at(times[i]) * camera.cam_T_imu.inverse();
      const SE3 now_T_last = pose.inverse() * last_pose;
      std::map<LandmarkId, Eigen::Vector3d> now;
      for (const PixelObservation& o : features.pixels) {
        const Eigen::Vector3d f = unproject(camera, o.pixel)->ray.normalized();
        now[o.landmark] = f;
        if (!last.contains(o.landmark)) continue;
        const Eigen::Vector3d r = now_T_last.R * last.at(o.landmark);
        const Eigen::Vector3d normal = now_T_last.p.cross(r).normalized();
        all += 1;
        if (std::min(std::abs(f.dot(normal)), (f - r).norm()) < 2 / 458.0) good += 1;
      }
      last = now;
      last_pose = pose;
    }
    std::cout << "kind " << kind << ": tracked " << tracked << ", mean age at the end " << age
              << ", within 2 px of the true epipolar line " << good / all << '\n';
    EXPECT_GT(tracked, 120) << kind;
    EXPECT_GT(good, 0.99 * all) << kind;
  }
}

TEST(ViconRoom, StereoMatchesOfSinglePairsLieOnTheEpipolarLines) {
  const auto folder = euroc_folder();
  if (!folder) GTEST_SKIP() << "no recordings";
  const std::vector<Camera> rig = euroc_rig();
  std::vector<fs::path> firsts;
  for (const auto& entry : fs::directory_iterator(*folder / "V1_01_easy_sparse_stereo")) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with("_0.jpg")) firsts.push_back(entry.path());
  }
  std::sort(firsts.begin(), firsts.end());
  ASSERT_GT(firsts.size(), 10U);
  double corners = 0, matched = 0, wide = 0, on_line = 0;
  const SE3 cam1_T_cam0 = rig[1].cam_T_imu * rig[0].cam_T_imu.inverse();
  for (const fs::path& first : firsts) {
    std::string other = first.string();
    other.replace(other.size() - 5, 1, "1");
    const ImageFrame frame{.time = Time(1), .images = {read_image(first), read_image(other)}};
    const auto count = [&](const FrontendSettings& settings, auto&& see) {
      Frontend frontend(settings, rig);
      std::map<LandmarkId, Eigen::Vector2d> of_first;
      for (const PixelObservation& o : frontend.process(frame).pixels) {
        if (o.camera == 0) of_first[o.landmark] = o.pixel;
        if (o.camera == 1) see(of_first.at(o.landmark), o.pixel);
      }
      return static_cast<double>(frontend.report().added);
    };
    corners += count({}, [&](const Eigen::Vector2d&, const Eigen::Vector2d&) { matched += 1; });
    // Without the geometric check, patches that follow the image only still end on the line.
    count({.epipolar_threshold = 15}, [&](const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
      const Eigen::Vector3d r = cam1_T_cam0.R * unproject(rig[0], p)->ray;
      const Eigen::Vector3d f = unproject(rig[1], q)->ray.normalized();
      wide += 1;
      if (std::abs(f.dot(cam1_T_cam0.p.cross(r).normalized())) < 1.5 / 458) on_line += 1;
    });
  }
  std::cout << firsts.size() << " pairs: " << matched << " of " << corners
            << " corners matched; with a threshold of 15 px, within 1.5 px of the line: "
            << on_line / wide << " of " << wide << '\n';
  EXPECT_GT(matched, 0.6 * corners);
  EXPECT_GT(on_line, 0.95 * wide);
}

}  // namespace
}  // namespace chasles::test
