#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include <chasles/recording/readers.hpp>

#include "messages_testing.hpp"
#include "robot_driver.hpp"

// dds_player RECORDING DOMAIN SPEED: the drivers of a robot. Publishes the recording at that speed
// (0: as fast as it goes, and reliably), listens to /odometry, and prints one line of JSON.

namespace {

using chasles::Time;
using Clock = chasles::test::RobotDriver::Clock;

std::string figures(const chasles::test::RobotDriver& driver,
                    const std::vector<chasles::test::FastReader::Message>& messages) {
  std::vector<double> ms;  // from sending the frame's last image to its odometry
  for (const auto& message : messages) {
    const Time time = chasles::test::odometry(message.bytes).time;
    // The odometry is by the IMU's clock, which differs by the estimated offset.
    const auto after = driver.sent().lower_bound(time - std::chrono::milliseconds(20));
    if (after == driver.sent().end()) continue;
    ms.push_back(std::chrono::duration<double, std::milli>(message.came - after->second).count());
  }
  std::ranges::sort(ms);
  const auto quantile = [&](double p) {
    return ms.empty() ? 0 : ms[static_cast<std::size_t>(p * static_cast<double>(ms.size() - 1))];
  };
  return fmt::format(
      "{{\"frames\": {}, \"odometry\": {}, \"latency_ms\": {{\"p50\": {:.2f}, \"p99\": {:.2f}, "
      "\"max\": {:.2f}}}}}\n",
      driver.sent().size(), messages.size(), quantile(0.5), quantile(0.99), quantile(1));
}

int play(const std::string& path, int domain, double speed) {
  const chasles::Recording recording = chasles::read_recording(path);
  chasles::test::FastClient client(domain);
  const chasles::test::FastReader odometry(client,
                                           {"rt/odometry", "nav_msgs::msg::dds_::Odometry_"}, true);
  // A stamp of 0 is none: a simulated recording begins later.
  const Time offset(first_event(recording) == Time::zero() ? 1'000'000'000 : 0);
  chasles::test::RobotDriver driver(client, recording, speed <= 0, offset);
  const chasles::test::FastReader diagnostics(
      client, {"rt/diagnostics", "diagnostic_msgs::msg::dds_::DiagnosticArray_"}, true);
  if (!driver.await_bridge(diagnostics, std::chrono::seconds(20))) {
    fmt::print(stderr, "dds_player: nobody listens in the domain {}\n", domain);
    return 1;
  }
  driver.play(speed);
  if (speed <= 0) driver.acknowledged(std::chrono::seconds(60));
  std::this_thread::sleep_for(std::chrono::seconds(1));
  fmt::print("{}", figures(driver, odometry.messages()));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    fmt::print(stderr, "dds_player RECORDING DOMAIN SPEED\n");
    return 1;
  }
  try {
    return play(argv[1], std::stoi(argv[2]), std::stod(argv[3]));
  } catch (const std::exception& error) {
    fmt::print(stderr, "dds_player: {}\n", error.what());
    return 1;
  }
}
