// SLAM for a program of your own, with the sensors on standard input:
//
//   sensors | feed_from_stdin CALIBRATION [--wait]
//
// CALIBRATION is what read_sensor_calibration() reads: Kalibr's camera chain and imu.yaml,
// calibration.yaml, or a folder in EuRoC's format. The input is a sequence of
//
//   imu TIME WX WY WZ FX FY FZ\n      TIME [ns]; angular rate [rad/s] and specific force [m/s^2]
//   images TIME\n                     and then, for each camera, width x height bytes: a grey image
//
// in the order of their arrival. Each estimate is a line: time [s], position [m], its largest sigma
// [m], how old the image is [ms], and how many images were dropped so far.
//
// The estimator has a thread of its own. By default the input never waits: where the estimator is
// slower than the sensors, the oldest waiting images are dropped and counted, so that the age stays
// bounded. With --wait nothing is dropped: reading stops while images wait, so that the pipe fills
// and whoever writes into it waits (back-pressure). That is for recordings, not for sensors.

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <iostream>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <sstream>
#include <string>
#include <thread>

#include <chasles/base/error.hpp>
#include <chasles/pipeline/realtime_slam.hpp>
#include <chasles/recording/sensor_calibration.hpp>

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::size_t kMostImages = 3;  // that wait for the estimator

chasles::Time time_from(std::istream& in) {
  std::int64_t nanoseconds = 0;
  in >> nanoseconds;
  return chasles::Time(nanoseconds);
}

// When each image came, by its time stamp.
class Arrivals {
 public:
  void note(chasles::Time stamp) {
    const std::lock_guard lock(mutex_);
    arrived_[stamp] = Clock::now();
  }
  // The age of the image whose estimate has this time; older ones are discarded. An estimated time
  // offset moves the time of an estimate a little from the stamp of its image.
  double milliseconds_since(chasles::Time estimate) {
    const std::lock_guard lock(mutex_);
    auto image = arrived_.upper_bound(estimate + std::chrono::milliseconds(20));
    if (image == arrived_.begin()) return 0;
    const std::chrono::duration<double, std::milli> age = Clock::now() - std::prev(image)->second;
    arrived_.erase(arrived_.begin(), image);
    return age.count();
  }

 private:
  std::mutex mutex_;
  std::map<chasles::Time, Clock::time_point> arrived_;
};

chasles::ImageFrame images_from(std::istream& in, chasles::Time time,
                                const std::vector<chasles::Camera>& cameras) {
  chasles::ImageFrame frame{.time = time, .images = {}};
  for (const chasles::Camera& camera : cameras) {
    chasles::GrayImage image;
    image.width = camera.width;
    image.height = camera.height;
    image.pixels.resize(static_cast<std::size_t>(camera.width) *
                        static_cast<std::size_t>(camera.height));
    in.read(reinterpret_cast<char*>(image.pixels.data()),
            static_cast<std::streamsize>(image.pixels.size()));
    if (!in) throw chasles::InputError("standard input ends within an image");
    frame.images.push_back(std::move(image));
  }
  return frame;
}

int run(const std::string& calibration_file, bool wait) {
  const chasles::SensorCalibration calibration = chasles::read_sensor_calibration(calibration_file);
  Arrivals arrivals;
  std::size_t estimates = 0;
  // Called on the estimator's thread, and after the constructor below alone; at last with what
  // finish() gives.
  chasles::RealtimeSlam* counted = nullptr;
  const auto print = [&](std::span<const chasles::Estimate> some) {
    for (const chasles::Estimate& e : some) {
      ++estimates;
      const Eigen::Vector3d& p = e.world_T_imu.p;
      const double sigma = e.covariance.diagonal().segment<3>(3).cwiseSqrt().maxCoeff();
      std::printf("%.3f  %.3f %.3f %.3f  %.3f  %.1f %zu\n", chasles::to_seconds(e.time), p.x(),
                  p.y(), p.z(), sigma, arrivals.milliseconds_since(e.time),
                  counted->counts().dropped);
    }
    std::fflush(stdout);
  };
  chasles::RealtimeSlam slam(
      std::make_unique<chasles::VisualInertialSlam>(
          calibration.cameras, calibration.imu_noise, chasles::InertialRunSettings{},
          chasles::ImuBuffer::Options{.convention = calibration.imu_convention}),
      {.most_images = wait ? 0 : kMostImages},
      [&](std::span<const chasles::Estimate> some, chasles::VisualInertialSlam&) { print(some); });
  counted = &slam;

  std::string line;
  for (std::size_t number = 1; std::getline(std::cin, line); ++number) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    const chasles::Time time = time_from(words);
    if (kind == "imu") {
      chasles::ImuSample sample;
      sample.time = time;
      for (double& rate : sample.angular_rate_imu) words >> rate;
      for (double& force : sample.specific_force_imu) words >> force;
      if (words) slam.process(chasles::corrected_sample(calibration, sample));
    } else if (kind == "images" && words) {
      chasles::ImageFrame frame = images_from(std::cin, time, calibration.cameras);
      arrivals.note(time);
      while (wait && slam.counts().waiting >= kMostImages) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      slam.process(std::move(frame));
    }
    if ((kind != "imu" && kind != "images") || !words) {
      throw chasles::InputError("standard input, item " + std::to_string(number) + ": found '" +
                                line.substr(0, 80) +
                                "', expected imu TIME WX WY WZ FX FY FZ, or images TIME");
    }
  }
  print(slam.finish());  // of the images that waited for further samples
  std::string why;
  slam.ask([&](chasles::VisualInertialSlam& s) { why = s.estimator().why_not_started(); });
  const chasles::RealtimeSlam::Counts images = slam.counts();
  std::fprintf(stderr, "%zu estimates of %zu images, %zu dropped\n", estimates, images.came,
               images.dropped);
  if (estimates == 0) std::fprintf(stderr, "%s\n", why.c_str());
  return estimates > 0 ? 0 : 1;
}

}  // namespace

int main(int count, char** arguments) {
  const bool wait = count == 3 && std::string(arguments[2]) == "--wait";
  if (count != 2 && !wait) {
    std::fprintf(stderr, "usage: sensors | feed_from_stdin CALIBRATION [--wait]\n");
    return 2;
  }
  try {
    return run(arguments[1], wait);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "feed_from_stdin: %s\n", error.what());
    return 1;
  }
}
