#include "parameters.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <utility>

#include <Eigen/Core>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/session/inertial_settings_io.hpp>

namespace chasles::ros1 {
namespace {

using Value = XmlRpc::XmlRpcValue;
/// By name, with the names of groups before a dot.
using Flat = std::map<std::string, Value>;

void flatten(const Value& tree, const std::string& prefix, Flat& flat) {
  for (const auto& [name, value] : tree) {
    if (value.getType() == Value::TypeStruct) {
      flatten(value, prefix + name + ".", flat);
    } else {
      flat[prefix + name] = value;
    }
  }
}

/// As the user writes it.
std::string parameter_name(std::string name) {
  std::replace(name.begin(), name.end(), '.', '/');
  return "~" + name;
}

std::string text_of(const Value& value) {
  switch (value.getType()) {
    case Value::TypeBoolean:
      return static_cast<const bool&>(value) ? "true" : "false";
    case Value::TypeInt:
      return fmt::format("{}", static_cast<const int&>(value));
    case Value::TypeDouble:
      return fmt::format("{}", static_cast<const double&>(value));
    case Value::TypeString:
      return static_cast<const std::string&>(value);
    case Value::TypeArray: {
      std::string text;
      for (int i = 0; i < value.size(); ++i) text += (i == 0 ? "" : ", ") + text_of(value[i]);
      return "[" + text + "]";
    }
    default:
      return "a value of another type";
  }
}

[[noreturn]] void reject(const std::string& name, const Value& value, const std::string& expected) {
  throw UsageError(
      fmt::format("{}: found '{}', expected {}", parameter_name(name), text_of(value), expected));
}

bool is_number(const Value& value) {
  return value.getType() == Value::TypeInt || value.getType() == Value::TypeDouble;
}
double number_of(const Value& value) {
  return value.getType() == Value::TypeInt ? static_cast<const int&>(value)
                                           : static_cast<const double&>(value);
}

/// Reads one parameter of the node itself.
using Read = std::function<void(const std::string& name, const Value& value)>;

template <typename Text>
Read text_to(Text& to) {
  return [&to](const std::string& name, const Value& value) {
    if (value.getType() != Value::TypeString) reject(name, value, "a text");
    to = static_cast<const std::string&>(value);
  };
}

Read flag_to(bool& to) {
  return [&to](const std::string& name, const Value& value) {
    if (value.getType() != Value::TypeBoolean) reject(name, value, "true or false");
    to = static_cast<const bool&>(value);
  };
}

Read seconds_to(double& to) {
  return [&to](const std::string& name, const Value& value) {
    if (!is_number(value) || !(number_of(value) >= 0)) reject(name, value, "seconds, 0 or more");
    to = number_of(value);
  };
}

Read count_to(int& to, int least, int most) {
  return [&to, least, most](const std::string& name, const Value& value) {
    const bool whole = value.getType() == Value::TypeInt;
    const int number = whole ? static_cast<const int&>(value) : 0;
    if (!whole || number < least || number > most) {
      reject(name, value, fmt::format("a whole number from {} to {}", least, most));
    }
    to = number;
  };
}

void read_topics(const std::string& name, const Value& value, std::vector<std::string>& topics) {
  const char* const expected = "a list of topics, one for each camera in order";
  if (value.getType() != Value::TypeArray) reject(name, value, expected);
  for (int i = 0; i < value.size(); ++i) {
    if (value[i].getType() != Value::TypeString) reject(name, value, expected);
    topics.push_back(static_cast<const std::string&>(value[i]));
  }
}

SE3 motion_of(const std::string& name, const Value& value) {
  const char* const expected = "a list [x, y, z, qx, qy, qz, qw], metres and a unit quaternion";
  if (value.getType() != Value::TypeArray || value.size() != 7) reject(name, value, expected);
  Eigen::Matrix<double, 7, 1> v;
  for (int i = 0; i < 7; ++i) {
    if (!is_number(value[i])) reject(name, value, expected);
    v[i] = number_of(value[i]);
  }
  try {
    return {checked_quaternion(parameter_name(name), v.tail<4>()), v.head<3>()};
  } catch (const InputError&) {
    reject(name, value, expected);
  }
}

/// The parameters of the node itself, by name.
std::map<std::string, Read> readers_of(NodeParameters& p, std::string& config,
                                       std::string& estimator) {
  return {
      {"calibration", text_to(p.calibration)},
      {"imu_topic", text_to(p.imu_topic)},
      {"accelerometer_topic", text_to(p.accelerometer_topic)},
      {"camera_topics",
       [&p](const auto& name, const auto& value) { read_topics(name, value, p.camera_topics); }},
      {"image_transport", text_to(p.image_transport)},
      {"cameras",
       [&p](const auto& name, const auto& value) {
         const std::string text = text_of(value);
         if (text != "mono" && text != "stereo") reject(name, value, "mono or stereo");
         p.cameras = text == "mono" ? 1 : 2;
       }},
      {"image_bits", count_to(p.image_bits, 0, 16)},
      {"config", text_to(config)},
      {"estimator", text_to(estimator)},
      {"map", text_to(p.robot.map)},
      {"lossless", flag_to(p.robot.lossless)},
      {"most_images", count_to(p.robot.most_images, 1, 10'000)},
      {"name", text_to(p.robot.name)},
      {"save_map", text_to(p.robot.save_map)},
      {"output", text_to(p.robot.output)},
      {"map_frame", text_to(p.map_frame)},
      {"odom_frame", text_to(p.odom_frame)},
      {"base_frame", text_to(p.base_frame)},
      {"imu_frame", text_to(p.imu_frame)},
      {"base_T_imu",
       [&p](const auto& name, const auto& value) { p.base_T_imu = motion_of(name, value); }},
      {"publish_tf", flag_to(p.publish_tf)},
      {"path_period", seconds_to(p.path_period)},
      {"path_length", count_to(p.path_length, 1, 10'000'000)},
      {"points_period", seconds_to(p.points_period)},
  };
}

std::vector<std::string> setting_names() {
  std::vector<std::string> names;
  const nlohmann::ordered_json settings = settings_json(InertialRunSettings{});
  for (const auto& [name, value] : settings.items()) names.push_back(name);
  return names;
}

[[noreturn]] void reject_unknown(const std::string& name,
                                 const std::map<std::string, Read>& readers,
                                 std::vector<std::string> known) {
  for (const auto& [own, read] : readers) known.push_back(own);
  std::string nearest = did_you_mean(name, known);
  std::replace(nearest.begin(), nearest.end(), '.', '/');
  throw UsageError(fmt::format(
      "{}: unknown parameter{} (docs/ros.md lists those of the node, and `chasles run --help` the "
      "settings)",
      parameter_name(name), nearest));
}

void check(const NodeParameters& p) {
  if (p.calibration.empty()) {
    throw UsageError(
        "~calibration is missing, expected a file or folder: Kalibr's camchain with imu.yaml, or "
        "the project's calibration.yaml (docs/ros.md)");
  }
  if (p.image_transport != "raw" && p.image_transport != "compressed") {
    throw UsageError(
        fmt::format("~image_transport: found '{}', expected raw or compressed", p.image_transport));
  }
  if (p.image_bits != 0 && p.image_bits < 8) {
    throw UsageError(fmt::format("~image_bits: found '{}', expected 0, or 8 to 16", p.image_bits));
  }
}

}  // namespace

NodeParameters parameters_from(const Value& tree) {
  Flat flat;
  if (tree.getType() == Value::TypeStruct) flatten(tree, "", flat);
  NodeParameters parameters;
  SettingSources sources;
  sources.set_option = "parameter";
  std::string estimator = "filter";
  const std::map<std::string, Read> readers = readers_of(parameters, sources.config, estimator);
  const std::vector<std::string> settings = setting_names();
  for (const auto& [name, value] : flat) {
    if (const auto own = readers.find(name); own != readers.end()) {
      own->second(name, value);
    } else if (std::ranges::find(settings, name) != settings.end()) {
      sources.sets.push_back(name + "=" + text_of(value));
    } else {
      reject_unknown(name, readers, settings);
    }
  }
  check(parameters);
  sources.estimator = estimator_choice(estimator, "~estimator");
  parameters.robot.settings = inertial_run_settings_from(sources);
  return parameters;
}

}  // namespace chasles::ros1
