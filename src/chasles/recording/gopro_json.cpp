#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <string_view>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/imu_units.hpp>
#include <chasles/codec/json_numbers.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/gopro_json.hpp>
#include <chasles/video/sample_times.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr const char* kForceKey = "ACCL";
constexpr const char* kRateKey = "GYRO";

// Which axis each of the three numbers is: from "Gyroscope (z,x,y)"; z, x, y without it, as in
// "Accelerometer (up/down, right/left, forward/back)".
std::array<Eigen::Index, 3> axes_of_name(const std::string& name) {
  constexpr std::string_view kLetters = "xyz";
  std::string letters;
  for (std::size_t i = name.find('('); i < name.size(); ++i) {
    const auto c = static_cast<char>(std::tolower(static_cast<unsigned char>(name[i])));
    if (std::isalpha(static_cast<unsigned char>(c)) != 0) letters += c;
  }
  std::array<Eigen::Index, 3> axes{2, 0, 1};
  if (letters.size() != 3 || letters.find_first_not_of(kLetters) != std::string::npos) return axes;
  for (std::size_t i = 0; i < 3; ++i) {
    axes[i] = static_cast<Eigen::Index>(kLetters.find(letters[i]));
  }
  const bool each_once = axes[0] != axes[1] && axes[0] != axes[2] && axes[1] != axes[2];
  return each_once ? axes : std::array<Eigen::Index, 3>{2, 0, 1};
}

// The unit of a stream, whose squares may be written by UTF-8's superscript.
double unit_factor(const JsonPlace& stream, bool force) {
  if (!stream.has("units")) return 1;
  std::string unit = stream.text("units");
  for (std::size_t at = 0; (at = unit.find("\xc2\xb2")) != std::string::npos;) {
    unit = fmt::format("{}2{}", unit.substr(0, at), unit.substr(at + 2));
  }
  const auto factor = factor_of_unit(unit, force ? ImuQuantity::kForce : ImuQuantity::kRate);
  if (factor) return *factor;
  throw InputError(fmt::format("{}.units: found '{:.40}', expected {}", stream.where(), unit,
                               force ? "m/s2 or g" : "rad/s or deg/s"));
}

JsonPlace samples_of_stream(const JsonPlace& stream) {
  JsonPlace samples = stream.at("samples");
  if (samples.is_list() && samples.size() > 0) return samples;
  throw InputError(fmt::format("{}: expected a list of samples", samples.where()));
}

// [s]
double time_of_sample(const JsonPlace& sample) {
  const double milliseconds = sample.number("cts");
  if (std::abs(milliseconds) < 1e3 * static_cast<double>(kLastSecond)) return 1e-3 * milliseconds;
  throw InputError(fmt::format("{}.cts: found {} ms, expected a time up to the year 2115",
                               sample.where(), milliseconds));
}

SensorStream read_stream(const fs::path& file, const JsonPlace& stream, const char* key) {
  const double factor = unit_factor(stream, key == std::string_view(kForceKey));
  const auto axes = axes_of_name(stream.has("name") ? stream.text("name") : "");
  SensorStream read{.name = fmt::format("{} of {}", key, file.filename().string()), .samples = {}};
  const JsonPlace samples = samples_of_stream(stream);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const JsonPlace sample = samples.at(i), value = sample.at("value");
    if (value.size() != 3) {
      throw InputError(
          fmt::format("{}: has {} numbers, expected three", value.where(), value.size()));
    }
    AxesSample& s = read.samples.emplace_back();
    s.time = from_seconds(time_of_sample(sample));
    for (std::size_t c = 0; c < 3; ++c) s.value[axes[c]] = factor * value.number(c);
  }
  return read;
}

// Its samples as blocks of one each, stamped by `cts`; none where a time is negative.
std::vector<SampleBlock> blocks_of_stream(const JsonPlace& stream) {
  const JsonPlace samples = samples_of_stream(stream);
  std::vector<SampleBlock> blocks;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double microseconds = 1e6 * time_of_sample(samples.at(i));
    if (microseconds < 0) return {};
    blocks.push_back({.payload = i,
                      .first = i,
                      .count = 1,
                      .stamp = static_cast<std::uint64_t>(std::llround(microseconds))});
  }
  return blocks;
}

// From microseconds of `cts` to seconds of the video.
Line clock_of_cts(const JsonPlace& streams, const GoproJson& imu,
                  const std::vector<VideoPicture>& pictures, std::string& by) {
  for (const char* key : kStreamsOfPictures) {
    if (!streams.has(key)) continue;
    const auto line = clock_by_pictures(blocks_of_stream(streams.at(key)), pictures);
    if (!line) continue;
    by = fmt::format("by the clock of the pictures' {}", key);
    return *line;
  }
  by = "the first one at the first picture, for no stream has a sample for each";
  const Time first = std::min(imu.forces.samples.front().time, imu.rates.samples.front().time);
  return {.x0 = 1e6 * to_seconds(first), .y0 = to_seconds(pictures.front().time), .slope = 1e-6};
}

}  // namespace

bool is_gopro_json(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string begin(4096, '\0');
  stream.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<std::size_t>(stream.gcount()));
  return begin.find("\"streams\"") != std::string::npos;
}

GoproJson read_gopro_json(const fs::path& file, const std::vector<VideoPicture>& pictures,
                          std::vector<std::string>& remarks) {
  const JsonFile json(file);
  // The devices have numbers; a camera is the first one.
  for (int device = 1; device <= 9; ++device) {
    const std::string name = std::to_string(device);
    if (!json.root().has(name) || !json.root().at(name).has("streams")) continue;
    const JsonPlace streams = json.root().at(name).at("streams");
    if (!streams.has(kForceKey) && !streams.has(kRateKey)) continue;
    GoproJson imu{.forces = read_stream(file, streams.at(kForceKey), kForceKey),
                  .rates = read_stream(file, streams.at(kRateKey), kRateKey)};
    std::string by;
    const Line clock = clock_of_cts(streams, imu, pictures, by);
    for (std::vector<AxesSample>* samples : {&imu.forces.samples, &imu.rates.samples}) {
      for (AxesSample& s : *samples) s.time = from_seconds(clock(1e6 * to_seconds(s.time)));
    }
    remarks.push_back(
        fmt::format("the samples of the IMU are those of {}, {}", file.filename().string(), by));
    return imu;
  }
  throw InputError(fmt::format(
      "{}: has no device '1' with the streams ACCL and GYRO, expected what gopro-telemetry writes "
      "(docs/videos.md)",
      file.string()));
}

}  // namespace chasles
