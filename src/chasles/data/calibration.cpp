#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <yaml-cpp/yaml.h>

#include <chasles/data/calibration.hpp>
#include <chasles/data/numbers.hpp>
#include <chasles/data/parse.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

constexpr const char* kFormat = "chasles-recording-1";

const std::vector<std::string>& known_keys() {
  static const std::vector<std::string> keys{"format",
                                             "name",
                                             "fx",
                                             "fy",
                                             "cx",
                                             "cy",
                                             "baseline",
                                             "cam0_T_imu",
                                             "remarks",
                                             "linear_sigma",
                                             "angular_sigma",
                                             "pixel_sigma"};
  return keys;
}

bool optional_key(const std::string& key) { return key == "remarks" || key.ends_with("_sigma"); }

// The keys of the file, each of them known, and all there that must be.
class Document {
 public:
  explicit Document(const std::filesystem::path& file) : file_(file.string()) {
    try {
      root_ = YAML::Load(read_file(file));
    } catch (const YAML::Exception& error) {
      throw InputError(
          fmt::format("{}:{}: is not valid YAML: {}", file_, error.mark.line + 1, error.msg));
    }
    if (!root_.IsMap()) throw InputError(file_ + ": expected lines `key: value`");
    check_keys();
  }

  std::string where(const YAML::Node& node, const std::string& key) const {
    return fmt::format("{}:{}: key '{}'", file_, node.Mark().line + 1, key);
  }
  YAML::Node at(const std::string& key) const { return root_[key]; }
  std::string text(const std::string& key) const { return scalar(root_[key], key); }
  double number(const std::string& key) const { return number(root_[key], key); }
  double positive(const std::string& key) const {
    return checked_positive(where(root_[key], key), number(key));
  }
  std::string scalar(const YAML::Node& node, const std::string& key) const {
    if (!node.IsScalar()) throw InputError(where(node, key) + ": expected a single value");
    return node.Scalar();
  }
  double number(const YAML::Node& node, const std::string& key) const {
    return parse_finite(where(node, key), scalar(node, key));
  }

 private:
  void check_keys() const {
    std::vector<std::string> found;
    for (const auto& entry : root_) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "";
      if (std::find(known_keys().begin(), known_keys().end(), key) == known_keys().end()) {
        throw InputError(fmt::format("{}: is unknown, expected one of {}{}",
                                     where(entry.first, key), quoted_list(known_keys()),
                                     did_you_mean(key, known_keys())));
      }
      if (std::find(found.begin(), found.end(), key) != found.end()) {
        throw InputError(where(entry.first, key) + ": is there twice, expected once");
      }
      found.push_back(key);
    }
    for (const std::string& key : known_keys()) {
      if (optional_key(key) || std::find(found.begin(), found.end(), key) != found.end()) continue;
      throw InputError(fmt::format("{}: key '{}' is missing, expected {}", file_, key,
                                   quoted_list(known_keys())));
    }
  }

  std::string file_;
  YAML::Node root_;
};

SE3 read_motion(const Document& document, const std::string& key) {
  const YAML::Node rows = document.at(key);
  const auto four = [&](const YAML::Node& node) { return node.IsSequence() && node.size() == 4; };
  const std::string where = document.where(rows, key);
  Eigen::Matrix4d M;
  if (!four(rows)) throw InputError(where + ": expected four rows of four numbers");
  for (std::size_t i = 0; i < 4; ++i) {
    if (!four(rows[i])) {
      throw InputError(document.where(rows[i], key) + ": expected a row of four numbers");
    }
    for (std::size_t j = 0; j < 4; ++j) {
      M(static_cast<int>(i), static_cast<int>(j)) = document.number(rows[i][j], key);
    }
  }
  return checked_motion(where, M);
}

// Standard deviations, one for each of `size` components; none where the key is missing.
std::optional<Eigen::VectorXd> read_sigma(const Document& document, const std::string& key,
                                          std::size_t size) {
  const YAML::Node node = document.at(key);
  if (!node.IsDefined()) return std::nullopt;
  const std::string where = document.where(node, key);
  if (!node.IsSequence() || node.size() != size) {
    throw InputError(fmt::format("{}: expected a list of {} standard deviations", where, size));
  }
  Eigen::VectorXd sigma(static_cast<Eigen::Index>(size));
  for (std::size_t i = 0; i < size; ++i) {
    sigma(static_cast<Eigen::Index>(i)) = checked_positive(where, document.number(node[i], key));
  }
  return sigma;
}

void read_stated_noise(const Document& document, Calibration& calibration) {
  const auto linear = read_sigma(document, "linear_sigma", 3);
  const auto angular = read_sigma(document, "angular_sigma", 3);
  if (linear.has_value() != angular.has_value()) {
    const std::string key = linear ? "linear_sigma" : "angular_sigma";
    throw InputError(document.where(document.at(key), key) +
                     ": linear_sigma and angular_sigma are expected both or neither");
  }
  if (linear) calibration.velocity_sigma = BodyVelocitySigma{*linear, *angular};
  if (const auto pixels = read_sigma(document, "pixel_sigma", 4)) calibration.pixel_sigma = *pixels;
}

std::string listed(const Eigen::VectorXd& values) {
  return fmt::format("[{}]", fmt::join(values.begin(), values.end(), ", "));
}

std::string stated_noise_text(const Calibration& calibration) {
  std::string text;
  if (calibration.velocity_sigma) {
    text += fmt::format(
        "# White noise of a velocity sample, standard deviations [m/s], [rad/s].\n"
        "linear_sigma: {}\nangular_sigma: {}\n",
        listed(calibration.velocity_sigma->linear), listed(calibration.velocity_sigma->angular));
  }
  if (calibration.pixel_sigma) {
    text += fmt::format(
        "# White noise of (uL, vL, uR, vR), standard deviations [px].\npixel_sigma: {}\n",
        listed(*calibration.pixel_sigma));
  }
  return text;
}

std::string quoted(const std::string& text) { return nlohmann::json(text).dump(); }

}  // namespace

Calibration read_calibration(const std::filesystem::path& file) {
  const Document document(file);
  if (document.text("format") != kFormat) {
    throw InputError(fmt::format("{}: is '{}', expected '{}'",
                                 document.where(document.at("format"), "format"),
                                 document.text("format"), kFormat));
  }
  Calibration calibration{.name = document.text("name"),
                          .rig = {.fx = document.positive("fx"),
                                  .fy = document.positive("fy"),
                                  .cx = document.number("cx"),
                                  .cy = document.number("cy"),
                                  .baseline = document.positive("baseline"),
                                  .cam0_T_imu = read_motion(document, "cam0_T_imu")},
                          .remarks = {},
                          .velocity_sigma = {},
                          .pixel_sigma = {}};
  read_stated_noise(document, calibration);
  const YAML::Node remarks = document.at("remarks");
  if (remarks.IsDefined() && !remarks.IsSequence()) {
    throw InputError(document.where(remarks, "remarks") + ": expected a list of sentences");
  }
  for (const auto& remark : remarks) {
    calibration.remarks.push_back(document.scalar(remark, "remarks"));
  }
  return calibration;
}

void write_calibration(const Calibration& calibration, const std::filesystem::path& file) {
  const StereoRig& rig = calibration.rig;
  std::string text = fmt::format(
      "# A recording of body velocities and stereo tracks (docs/formats.md).\n"
      "format: {}\n"
      "name: {}\n"
      "# Rectified stereo pair: focal lengths and principal point of both cameras [px].\n"
      "fx: {}\nfy: {}\ncx: {}\ncy: {}\n"
      "# The right camera lies this far along the left camera's x axis [m].\n"
      "baseline: {}\n"
      "# Maps IMU coordinates to those of the left camera [m]: p_cam0 = cam0_T_imu * p_imu.\n"
      "# imu: x forward, y left, z up on a car. cam0: x right, y down, z forward.\n"
      "cam0_T_imu:\n",
      kFormat, quoted(calibration.name), rig.fx, rig.fy, rig.cx, rig.cy, rig.baseline);
  const SE3& T = rig.cam0_T_imu;
  for (int i = 0; i < 3; ++i) {
    text += fmt::format("  - [{}, {}, {}, {}]\n", T.R(i, 0), T.R(i, 1), T.R(i, 2), T.p(i));
  }
  text += "  - [0, 0, 0, 1]\n";
  text += stated_noise_text(calibration);
  if (!calibration.remarks.empty()) text += "# What was corrected, dropped or counted.\nremarks:\n";
  for (const std::string& remark : calibration.remarks) {
    text += fmt::format("  - {}\n", quoted(remark));
  }
  write_file(file, text);
}

}  // namespace chasles
