#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/calibration/calibration.hpp>
#include <chasles/pipeline/run.hpp>
#include <chasles/pipeline/run_of_images_testing.hpp>
#include <chasles/recording/inertial_tables.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/testing.hpp>
#include <chasles/slam/inertial_session_testing.hpp>
#include <chasles/video/gpmf_testing.hpp>
#include <chasles/video/video_testing.hpp>

// Runs of a rendered walk: of its images, and of videos of them.
namespace chasles {
namespace {

namespace fs = std::filesystem;

/// Some images of a recording.
class SomeImages : public ImageSource {
 public:
  SomeImages(std::shared_ptr<const ImageSource> all, std::vector<std::size_t> chosen)
      : all_(std::move(all)), chosen_(std::move(chosen)) {}
  std::size_t size() const override { return chosen_.size(); }
  Time time(std::size_t i) const override { return all_->time(chosen_[i]); }
  ImageFrame read(std::size_t i) const override { return all_->read(chosen_[i]); }

 private:
  std::shared_ptr<const ImageSource> all_;
  std::vector<std::size_t> chosen_;
};

class VideoRun : public test::RunOfImages {
 protected:
  // At uneven times: every third image is missing.
  static Recording uneven_walk() {
    Recording recording = walk();
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < recording.images->size(); ++i) {
      if (i % 3 != 2) chosen.push_back(i);
    }
    recording.images = std::make_shared<SomeImages>(recording.images, chosen);
    return recording;
  }

  void SetUp() override {
    folder = test::scratch();
    const Recording recording = uneven_walk();
    write_calibration({.name = recording.name,
                       .cameras = recording.cameras,
                       .imu_convention = recording.imu_convention,
                       .imu_noise = recording.imu_noise,
                       .imu_range = recording.imu_range},
                      folder / "calibration.yaml");
    for (std::size_t i = 0; i < recording.images->size(); ++i) {
      pictures.push_back(recording.images->read(i));
    }
  }

  static std::vector<Estimate> estimates_of(Recording recording) {
    recording.exact_calibration = false;  // a video states neither
    recording.truth.clear();
    recording.remarks.clear();
    return chasles::run(recording, InertialRunSettings{}, {}).estimates;
  }

  // Of the poses of the same frames [m]. Their times have the offsets that the runs estimate.
  static double farthest(const std::vector<Estimate>& a, const std::vector<Estimate>& b) {
    double most = a.size() == b.size() && !a.empty() ? 0 : 1e9;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
      EXPECT_LT(std::abs(to_seconds(a[i].time - b[i].time)), 2e-3);
      most = std::max(most, (a[i].world_T_imu.p - b[i].world_T_imu.p).norm());
    }
    return most;
  }

  // The samples as a camera has them: single precision, Z, X, Y, a second in each payload, stamped
  // by a clock that begins earlier and runs 1.001 times as fast as that of the pictures.
  std::vector<test::TimedBytes> telemetry_of(const std::vector<ImuSample>& imu) const {
    const auto stamp_of = [](Time time) {
      return static_cast<std::uint64_t>(80'000 + std::llround(1e6 * 1.001 * to_seconds(time)));
    };
    const auto stream = [&](const std::string& key, std::size_t begin, std::size_t end,
                            Eigen::Vector3d ImuSample::*part) {
      std::string data;
      for (std::size_t i = begin; i < end; ++i) {
        const Eigen::Vector3d& v = imu[i].*part;
        for (const double value : {v.z(), v.x(), v.y()}) {
          data +=
              test::big_endian_bytes(std::bit_cast<std::uint32_t>(static_cast<float>(value)), 4);
        }
      }
      return test::nest("STRM", test::klv_stamp("STMP", stamp_of(imu[begin].time)) +
                                    test::klv_count("TSMP", static_cast<std::uint32_t>(end)) +
                                    test::klv_text("ORIN", "ZXY") +
                                    test::klv(key, 'f', 12, end - begin, data));
    };
    std::vector<test::TimedBytes> payloads;
    std::size_t begin = 0, picture = 0;
    for (Time at{}; begin < imu.size(); at += std::chrono::seconds(1)) {
      std::size_t end = begin, shown = picture;
      while (end < imu.size() && imu[end].time < at + std::chrono::seconds(1)) ++end;
      while (shown < pictures.size() && pictures[shown].time < at + std::chrono::seconds(1)) {
        ++shown;
      }
      std::string items = test::klv_count("DVID", 1) + test::klv_text("DVNM", "GoPro Test") +
                          stream("ACCL", begin, end, &ImuSample::specific_force_imu) +
                          stream("GYRO", begin, end, &ImuSample::angular_rate_imu);
      if (shown > picture) {
        const std::vector<std::vector<int>> rows(shown - picture, {1});
        items += test::nest("STRM", test::klv_stamp("STMP", stamp_of(pictures[picture].time)) +
                                        test::klv_count("TSMP", static_cast<std::uint32_t>(shown)) +
                                        test::klv_shorts("SHUT", rows));
      }
      payloads.push_back(
          {.time = at, .duration = std::chrono::seconds(1), .bytes = test::nest("DEVC", items)});
      begin = end;
      picture = shown;
    }
    return payloads;
  }

  fs::path folder;
  std::vector<ImageFrame> pictures;
};

TEST_F(VideoRun, ALosslessVideoGivesTheEstimatesOfItsImages) {
  const Recording images = uneven_walk();
  write_imu(images.imu, folder / "imu.csv");
  test::VideoWriter::write(folder / "walk.mp4", pictures, {.options = "qp=0"});
  const auto of_images = estimates_of(images);
  const auto of_video = estimates_of(read_recording(folder / "walk.mp4"));
  ASSERT_EQ(of_video.size(), of_images.size());
  for (std::size_t i = 0; i < of_images.size(); ++i) {
    ASSERT_EQ(of_video[i].time, of_images[i].time) << i;
    ASSERT_EQ(of_video[i].world_T_imu.p, of_images[i].world_T_imu.p) << i;
    ASSERT_EQ(of_video[i].covariance, of_images[i].covariance) << i;
  }
}

TEST_F(VideoRun, ACompressedVideoWithItsOwnTelemetryIsCentimetresFromIt) {
  const Recording images = uneven_walk();
  test::VideoWriter::write(folder / "walk.mp4", pictures,
                           {.options = "crf=23", .full_range = false, .key_every = 30},
                           telemetry_of(images.imu));
  const Recording video = read_recording(folder / "walk.mp4");
  ASSERT_NEAR(static_cast<double>(video.imu.size()), static_cast<double>(images.imu.size()), 2);
  EXPECT_NEAR(to_seconds(video.imu.front().time), to_seconds(images.imu.front().time), 1e-3);
  const auto of_images = estimates_of(images), of_video = estimates_of(video);
  EXPECT_LT(farthest(of_video, of_images), 0.05);
  EXPECT_LT(test::error_from(of_video, images), 0.1);
}

}  // namespace
}  // namespace chasles
