#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include <chasles/recording/testing.hpp>
#include <chasles/video/gpmf_testing.hpp>
#include <chasles/video/telemetry.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;

constexpr double kScale = 100;  // SCAL of both sensors

/// A sensor as a camera records it: when its samples are, by the clock of the video.
struct Sensor {
  std::string key;
  std::string unit;
  double first = 0;            // [s]
  double period = 0;           // [s]
  std::string statement = {};  // ORIN, MTRX
  double timo = 0;
};

/// A camera: its payloads begin at multiples of 1.001 s, and have the samples that came before
/// they end. The clock of its stamps has another zero and another rate than that of the pictures.
struct FakeCamera {
  std::vector<Sensor> sensors{{.key = "ACCL", .unit = "m/s\xb2", .first = 0.004, .period = 0.005},
                              {.key = "GYRO", .unit = "rad/s", .first = 0.034, .period = 0.0025}};
  bool stamps = true;
  bool of_pictures = true;    // SHUT
  bool totals = true;         // TSMP
  double stamp_zero = 85608;  // [us]
  double stamp_rate = 1;
  int payloads = 6;
  double payload_seconds = 1.001;
  int pictures_a_payload = 30;
  std::string name = "GoPro Test";
  std::function<double(const Sensor&, int)> value = [](const Sensor&, int i) {
    return static_cast<double>(i % 200);
  };

  std::uint64_t stamp_of(double video_seconds) const {
    return static_cast<std::uint64_t>(std::llround(stamp_zero + 1e6 * stamp_rate * video_seconds));
  }
  std::string stream(const std::string& key, double first, double period, int begin, int end,
                     const std::string& about, const std::string& samples) const {
    std::string items;
    const double at = first + period * begin;
    if (stamps && end > begin) items += test::klv_stamp("STMP", stamp_of(at));
    if (totals) items += test::klv_count("TSMP", static_cast<std::uint32_t>(end));
    items += test::klv_text("STNM", key) + about + samples;
    return test::nest("STRM", items);
  }
  std::string sensor_stream(const Sensor& s, int payload) const {
    const auto until = [&](int k) {
      return std::max(0, static_cast<int>(std::ceil((k * payload_seconds - s.first) / s.period)));
    };
    const int begin = payload == 0 ? 0 : until(payload), end = until(payload + 1);
    std::vector<std::vector<int>> rows;
    for (int i = begin; i < end; ++i) {  // Z, X, Y: a number of the sample, and marks of the axes
      rows.push_back({300, 100, static_cast<int>(kScale * value(s, i))});
    }
    std::string about = test::klv_text("SIUN", s.unit) +
                        test::klv_shorts("SCAL", {{static_cast<int>(kScale)}}) + s.statement;
    if (s.timo != 0) about += test::klv_float("TIMO", static_cast<float>(s.timo));
    return stream(s.key, s.first, s.period, begin, end, about, test::klv_shorts(s.key, rows));
  }
  std::string payload(int k) const {
    std::string items = test::klv_count("DVID", 1) + test::klv_text("DVNM", name);
    for (const Sensor& s : sensors) items += sensor_stream(s, k);
    if (of_pictures) {
      const std::vector<std::vector<int>> rows(static_cast<std::size_t>(pictures_a_payload), {1});
      items += stream("SHUT", 0, payload_seconds / pictures_a_payload, k * pictures_a_payload,
                      (k + 1) * pictures_a_payload, "", test::klv_shorts("SHUT", rows));
    }
    return test::nest("DEVC", items);
  }
  VideoIndex record() const {
    VideoIndex index;
    index.file = "walk.mp4";
    for (int i = 0; i < payloads * pictures_a_payload; ++i) {
      index.pictures.push_back(
          {.time = from_seconds(payload_seconds / pictures_a_payload * i), .pts = i});
    }
    for (int k = 0; k < payloads; ++k) {
      index.telemetry.push_back({.time = from_seconds(payload_seconds * k),
                                 .duration = from_seconds(payload_seconds),
                                 .bytes = payload(k)});
    }
    return index;
  }
};

struct Read {
  Telemetry telemetry;
  std::vector<std::string> remarks;
};

Read read(const VideoIndex& index) {
  Read result;
  result.telemetry = read_telemetry(index, result.remarks);
  return result;
}

// The largest error of the times of a sensor's samples [s].
double worst_time(const std::vector<AxesSample>& samples, const Sensor& sensor) {
  double worst = samples.empty() ? 1e9 : 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double truth = sensor.first + sensor.period * static_cast<double>(i);
    worst = std::max(worst, std::abs(to_seconds(samples[i].time) - truth));
  }
  return worst;
}

// The gyroscope begins 30 ms after the accelerometer and has twice its rate.
TEST(Telemetry, StampedSamplesHaveTheirTimesByTheClockOfThePictures) {
  for (const double rate : {1.0, 1.001, 0.9995}) {
    FakeCamera camera;
    camera.stamp_rate = rate;
    const auto [telemetry, remarks] = read(camera.record());
    EXPECT_GT(telemetry.forces.size(), 1190u);
    EXPECT_LT(worst_time(telemetry.forces, camera.sensors[0]), 2e-6) << rate;
    EXPECT_LT(worst_time(telemetry.rates, camera.sensors[1]), 2e-6) << rate;
    ASSERT_EQ(remarks.size(), 1u);
    expect_parts(remarks[0], {"1 GoPro Test", "accelerometer at 200 Hz", "gyroscope at 400 Hz",
                              "those of the pictures' SHUT"});
  }
}

// Each payload has as many samples as came, so their numbers vary: 200 and 201.
TEST(Telemetry, SamplesAtTheBordersOfPayloadsAreEven) {
  FakeCamera camera;
  const Telemetry telemetry = read(camera.record()).telemetry;
  for (const auto* samples : {&telemetry.forces, &telemetry.rates}) {
    const Time first = (*samples)[1].time - (*samples)[0].time;
    for (std::size_t i = 1; i < samples->size(); ++i) {
      EXPECT_LT(std::abs(to_seconds((*samples)[i].time - (*samples)[i - 1].time - first)), 1e-7);
    }
  }
}

TEST(Telemetry, WithoutAStreamOfPicturesTheOffsetBetweenTheSensorsStays) {
  FakeCamera camera;
  camera.of_pictures = false;
  const auto [telemetry, remarks] = read(camera.record());
  expect_parts(remarks.at(0), {"the start of the first payload"});
  EXPECT_EQ(telemetry.forces.front().time, Time(0));  // by 4 ms early, and so is the gyroscope
  const double apart = to_seconds(telemetry.rates.front().time - telemetry.forces.front().time);
  EXPECT_NEAR(apart, 0.030, 2e-6);
}

// A stream with one sample for two pictures; and one that does not fit the pictures at all.
TEST(Telemetry, AStreamOfEverySecondPictureCountsAndOneThatDoesNotFitDoesNot) {
  FakeCamera camera;
  VideoIndex index = camera.record();
  const std::vector<VideoPicture> pictures = index.pictures;
  index.pictures.clear();
  for (const VideoPicture& picture : pictures) {
    index.pictures.push_back(picture);
    index.pictures.push_back(
        {.time = picture.time + from_seconds(camera.payload_seconds / 60), .pts = 0});
  }
  Read result = read(index);
  expect_parts(result.remarks.at(0), {"the pictures' SHUT"});
  EXPECT_LT(worst_time(result.telemetry.rates, camera.sensors[1]), 2e-6);
  index.pictures = pictures;
  for (std::size_t i = 60; i < index.pictures.size(); ++i) {
    index.pictures[i].time += std::chrono::milliseconds(500);  // a pause of the video alone
  }
  expect_parts(read(index).remarks.at(0), {"the start of the first payload"});
}

// HERO5 and 6: no stamps. A payload has the samples that came until it ends.
TEST(Telemetry, UnstampedSamplesFollowTheStartsOfThePayloads) {
  FakeCamera camera;
  camera.stamps = false;
  camera.payloads = 30;
  const auto [telemetry, remarks] = read(camera.record());
  expect_parts(remarks.at(0), {"they have no stamps"});
  for (std::size_t s = 0; s < 2; ++s) {
    const auto& samples = s == 0 ? telemetry.forces : telemetry.rates;
    const Sensor& sensor = camera.sensors[s];
    const double interval = to_seconds(samples.back().time - samples.front().time) /
                            static_cast<double>(samples.size() - 1);
    EXPECT_NEAR(interval, sensor.period, 1e-4 * sensor.period);
    EXPECT_LT(worst_time(samples, sensor), sensor.period);
  }
}

TEST(Telemetry, ALostPayloadLeavesAGapAndMovesNothing) {
  for (const bool stamps : {true, false}) {
    FakeCamera camera;
    camera.stamps = stamps;
    camera.payloads = 12;
    VideoIndex index = camera.record();
    const auto whole = read(index);
    index.telemetry[5].bytes[6] = '\x7f';  // the size of the device
    const auto [telemetry, remarks] = read(index);
    expect_parts(remarks.at(0), {"1 of 12 payloads of telemetry are damaged", "at 5.005 s"});
    const auto& all = whole.telemetry.rates;
    const double lost = static_cast<double>(all.size() - telemetry.rates.size());
    EXPECT_NEAR(lost, 400, 2);
    EXPECT_LT(std::abs(to_seconds(all.back().time - telemetry.rates.back().time)),
              stamps ? 1e-6 : 1e-3);
    EXPECT_EQ(all.front().time - telemetry.rates.front().time < Time(1'000'000), true);
  }
}

TEST(Telemetry, AxesAreThoseThatTheStreamsState) {
  const auto first_force = [](const std::string& statement) {
    FakeCamera camera;
    camera.sensors[0].statement = statement;
    camera.value = [](const Sensor&, int) { return 2; };
    return read(camera.record()).telemetry.forces.front().value;
  };
  // The channels are 3, 1, 2.
  EXPECT_EQ(first_force(""), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(first_force(test::klv_text("ORIN", "ZXY")), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(first_force(test::klv_text("ORIN", "XzY")), Eigen::Vector3d(3, 2, -1));
  EXPECT_EQ(first_force(test::klv_text("ORIN", "YxZ")), Eigen::Vector3d(-1, 3, 2));
  // As the GoPro MAX has it: the matrix and the letters say the same.
  const std::string max = test::klv_matrix("MTRX", {0, -1, 0, 1, 0, 0, 0, 0, 1}) +
                          test::klv_text("ORIN", "XzY") + test::klv_text("ORIO", "ZXY");
  EXPECT_EQ(first_force(max), Eigen::Vector3d(3, 2, -1));
  // A matrix may scale, too.
  const std::string scaled = test::klv_matrix("MTRX", {0, -1, 0, 2, 0, 0, 0, 0, 1}) +
                             test::klv_text("ORIN", "XzY") + test::klv_text("ORIO", "ZXY");
  EXPECT_EQ(first_force(scaled), Eigen::Vector3d(6, 2, -1));
}

TEST(Telemetry, UnitsBecomeSiAndADelayIsSubtracted) {
  FakeCamera camera;
  camera.sensors[0].unit = "g";
  camera.sensors[0].timo = 0.25;
  camera.sensors[1].unit = "deg/s";
  camera.value = [](const Sensor&, int) { return 2; };
  const Telemetry telemetry = read(camera.record()).telemetry;
  EXPECT_NEAR(telemetry.forces[0].value.z(), 3 * 9.80665, 1e-9);
  EXPECT_NEAR(telemetry.rates[0].value.x(), M_PI / 180, 1e-9);
  EXPECT_NEAR(to_seconds(telemetry.forces[0].time), 0.004 - 0.25, 2e-6);
  EXPECT_NEAR(to_seconds(telemetry.rates[0].time), 0.034, 2e-6);
}

TEST(Telemetry, WhatCannotBeReadIsAnErrorWithWhatToDo) {
  const auto rejected = [](const std::function<void(FakeCamera&)>& change) {
    FakeCamera camera;
    change(camera);
    return input_error([&] { read(camera.record()); });
  };
  expect_parts(rejected([](FakeCamera& c) { c.sensors.pop_back(); }),
               {"walk.mp4: its telemetry has no samples of GYRO for those of ACCL"});
  expect_parts(rejected([](FakeCamera& c) { c.sensors.clear(); }),
               {"samples of neither sensor", "a table of an IMU beside the video"});
  expect_parts(rejected([](FakeCamera& c) { c.sensors[0].unit = "V"; }),
               {"telemetry ACCL: has the unit 'V', expected m/s^2 or g"});
  expect_parts(
      rejected([](FakeCamera& c) { c.sensors[1].statement = test::klv_text("ORIN", "XXY"); }),
      {"telemetry GYRO: states the axes 'XXY', expected X, Y and Z"});
  VideoIndex index = FakeCamera{}.record();
  for (TelemetryPayload& payload : index.telemetry)
    payload.bytes = std::string("DEVC\0\x04\xff\xff", 8);
  expect_parts(input_error([&] { read(index); }), {"walk.mp4: telemetry at 0.000 s", "DEVC"});
  index.telemetry.clear();
  expect_parts(input_error([&] { read(index); }), {"its telemetry (gpmd) is empty"});
}

}  // namespace
}  // namespace chasles
