#include <array>
#include <cctype>
#include <fstream>
#include <string_view>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/imu_units.hpp>
#include <chasles/codec/json_numbers.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/gopro_json.hpp>

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

SensorStream read_stream(const fs::path& file, const JsonPlace& stream, const char* key) {
  const bool force = key == kForceKey;
  const double factor = unit_factor(stream, force);
  const auto axes = axes_of_name(stream.has("name") ? stream.text("name") : "");
  SensorStream read{.name = fmt::format("{} of {}", key, file.filename().string()), .samples = {}};
  const JsonPlace samples = stream.at("samples");
  if (!samples.is_list()) {
    throw InputError(fmt::format("{}: expected a list of samples", samples.where()));
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const JsonPlace sample = samples.at(i), value = sample.at("value");
    if (value.size() != 3) {
      throw InputError(
          fmt::format("{}: has {} numbers, expected three", value.where(), value.size()));
    }
    const double seconds = 1e-3 * sample.number("cts");
    if (!(std::abs(seconds) < static_cast<double>(kLastSecond))) {
      throw InputError(
          fmt::format("{}.cts: found {} ms, expected the time since the start of the "
                      "video",
                      sample.where(), 1e3 * seconds));
    }
    AxesSample& s = read.samples.emplace_back();
    s.time = from_seconds(seconds);
    for (std::size_t c = 0; c < 3; ++c) s.value[axes[c]] = factor * value.number(c);
  }
  return read;
}

}  // namespace

bool is_gopro_json(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string begin(4096, '\0');
  stream.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<std::size_t>(stream.gcount()));
  return begin.find("\"streams\"") != std::string::npos;
}

GoproJson read_gopro_json(const fs::path& file, std::vector<std::string>& remarks) {
  const JsonFile json(file);
  // The devices are numbered; a camera is the first one.
  for (int device = 1; device <= 9; ++device) {
    const std::string name = std::to_string(device);
    if (!json.root().has(name) || !json.root().at(name).has("streams")) continue;
    const JsonPlace streams = json.root().at(name).at("streams");
    if (!streams.has(kForceKey) && !streams.has(kRateKey)) continue;
    remarks.push_back(
        fmt::format("the samples of the IMU are those of {}, by the video's clock "
                    "(cts), as axes x, y, z of the camera",
                    file.filename().string()));
    return {.forces = read_stream(file, streams.at(kForceKey), kForceKey),
            .rates = read_stream(file, streams.at(kRateKey), kRateKey)};
  }
  throw InputError(fmt::format(
      "{}: has no device '1' with the streams ACCL and GYRO, expected what gopro-telemetry writes "
      "(docs/videos.md)",
      file.string()));
}

}  // namespace chasles
