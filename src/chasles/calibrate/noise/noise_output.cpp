#include <array>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/calibrate/noise/noise_output.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

struct Sensor {
  const char* name;
  std::size_t first;  // signal
  const char* unit;
};
constexpr std::array kSensors = {Sensor{"accelerometer", 0, "m/s^2"},
                                 Sensor{"gyroscope", 3, "rad/s"}};
constexpr std::array kAxes = {"x", "y", "z"};

Json term_json(const NoiseTerm& term) {
  if (!term.shown) return {{"value", nullptr}, {"sigma", nullptr}, {"limit", term.limit}};
  return {
      {"value", term.value}, {"sigma", term.value * term.relative_sigma}, {"limit", term.limit}};
}

Json taken_json(const TakenNoise& taken) {
  return {{"value", taken.value}, {"is_limit", taken.is_limit}};
}

Json axis_json(const NoiseCalibration& c, std::size_t i) {
  Json json = {{"axis", kAxes[i % 3]}};
  if (c.standstill) {
    const StandstillSignal& s = (*c.standstill)[i];
    json["noise_density"] = term_json(s.fit.white);
    json["bias_instability"] = term_json(s.fit.instability);
    json["random_walk"] = term_json(s.fit.walk);
    json["random_walk_without_instability"] = s.fit.walk_without_instability;
    json["white_up_to_hz"] = s.fit.white_up_to;
    json["misfit"] = s.fit.misfit;
    json["mean"] = s.mean;
    json["sample_sigma"] = s.sample_sigma;
    json["resolution"] = std::isfinite(s.resolution) ? Json(s.resolution) : Json();
  }
  if (c.motion) {
    const MotionNoise& m = c.motion->signals[i];
    json["motion"] = {
        {"density", m.density}, {"sigma", m.density * m.relative_sigma}, {"quietest", m.quietest}};
  }
  return json;
}

Json sensor_json(const NoiseCalibration& c, const Sensor& sensor) {
  const auto walk = c.walk(sensor.first);
  Json json = {{"unit", sensor.unit},
               {"noise_density", taken_json(c.density(sensor.first))},
               {"random_walk", walk ? taken_json(*walk) : Json()},
               {"axes", Json::array()}};
  for (std::size_t i = sensor.first; i < sensor.first + 3; ++i) {
    json["axes"].push_back(axis_json(c, i));
  }
  return json;
}

Json standstill_json(const NoiseCalibration& c) {
  if (!c.standstill) return {};
  Json parts = Json::array();
  for (const StandstillTimes& times : c.standstills) parts.push_back({times.begin, times.end});
  return {{"seconds", c.standstill_seconds()}, {"parts_s", parts}};
}

std::string term_text(const NoiseTerm& term) {
  return term.shown ? fmt::format("{:.3g} +- {:.2g} %", term.value, 100 * term.relative_sigma)
                    : fmt::format("<= {:.2g}", term.limit);
}

std::string taken_text(const TakenNoise& taken) {
  return fmt::format("{}{:.3g}", taken.is_limit ? "<= " : "", taken.value);
}

template <typename Cell>
std::string row(const std::string& name, std::size_t first, Cell&& cell,
                const std::string& taken = "") {
  std::string text = fmt::format("{:<36}", name);
  for (std::size_t i = first; i < first + 3; ++i) text += fmt::format(" {:<19}", cell(i));
  text += " " + taken;
  text.erase(text.find_last_not_of(' ') + 1);
  return text + "\n";
}

std::string standstill_rows(const NoiseCalibration& c, const Sensor& sensor) {
  if (!c.standstill) return {};
  const auto term = [&](NoiseTerm NoiseFit::*part) {
    return [&c, part](std::size_t i) { return term_text((*c.standstill)[i].fit.*part); };
  };
  const std::string unit = sensor.unit;
  const auto number = [&](auto&& value) {
    return [&c, value](std::size_t i) { return fmt::format("{:.3g}", value((*c.standstill)[i])); };
  };
  return row(fmt::format("  noise density [{}/sqrt(Hz)]", unit), sensor.first,
             term(&NoiseFit::white), taken_text(c.density(sensor.first))) +
         row(fmt::format("  bias instability [{}]", unit), sensor.first,
             term(&NoiseFit::instability)) +
         row(fmt::format("  random walk [{}/s/sqrt(Hz)]", unit), sensor.first,
             term(&NoiseFit::walk), taken_text(*c.walk(sensor.first))) +
         row("  white up to [Hz]", sensor.first,
             number([](const StandstillSignal& s) { return s.fit.white_up_to; })) +
         row(fmt::format("  sigma of a sample [{}]", unit), sensor.first,
             number([](const StandstillSignal& s) { return s.sample_sigma; }));
}

std::string motion_rows(const NoiseCalibration& c, const Sensor& sensor) {
  if (!c.motion) return {};
  const std::string unit = fmt::format("[{}/sqrt(Hz)]", sensor.unit);
  return row("  in motion " + unit, sensor.first,
             [&](std::size_t i) {
               const MotionNoise& m = c.motion->signals[i];
               return fmt::format("{:.3g} +- {:.2g} %", m.density, 100 * m.relative_sigma);
             }) +
         row(
             "  quietest tenth of it", sensor.first,
             [&](std::size_t i) { return fmt::format("{:.3g}", c.motion->signals[i].quietest); },
             c.standstill ? "" : taken_text(c.density(sensor.first)));
}

std::string head_text(const NoiseCalibration& c) {
  std::string text = fmt::format("{}: {} IMU samples at {:.2f} Hz in {:.1f} s\n", c.recording,
                                 c.samples, c.rate, c.seconds);
  if (c.standstill) {
    text += fmt::format("standstill: {:.1f} s in {} part{}\n", c.standstill_seconds(),
                        c.standstills.size(), c.standstills.size() == 1 ? "" : "s");
  } else {
    text +=
        "standstill: less than 5 s. A motion shows no random walk, and a noise density with the "
        "vibration\n";
  }
  if (c.motion) {
    text += fmt::format("in motion: {:.1f} s, density from {:.0f} to {:.0f} Hz\n",
                        c.motion->seconds, c.motion->lowest, c.motion->highest);
  }
  if (c.interpolated + c.left_out + c.gaps > 0) {
    text += fmt::format("samples: {} lost and interpolated, {} left out, {} gaps\n", c.interpolated,
                        c.left_out, c.gaps);
  }
  return text;
}

std::string walk_line(const NoiseCalibration& c, const Sensor& sensor) {
  const auto walk = c.walk(sensor.first);
  const std::string key = fmt::format("{}_random_walk", sensor.name);
  if (!walk) {
    return fmt::format("# {}: a motion does not show it: take that of the data sheet\n", key);
  }
  return fmt::format("{}: {:.6g}{}\n", key, walk->value,
                     walk->is_limit ? "  # not shown: the limit, with 95 %" : "");
}

}  // namespace

Json noise_json(const NoiseCalibration& c) {
  Json json = {{"recording", c.recording},
               {"samples", c.samples},
               {"rate_hz", c.rate},
               {"seconds", c.seconds},
               {"interpolated", c.interpolated},
               {"left_out", c.left_out},
               {"gaps", c.gaps},
               {"standstill", standstill_json(c)},
               {"motion", Json()}};
  if (c.motion) {
    json["motion"] = {{"seconds", c.motion->seconds},
                      {"band_hz", {c.motion->lowest, c.motion->highest}}};
  }
  for (const Sensor& sensor : kSensors) json[sensor.name] = sensor_json(c, sensor);
  json["stated"] = Json();
  if (c.stated) {
    json["stated"] = {{"accelerometer_noise_density", c.stated->accelerometer_noise_density},
                      {"accelerometer_random_walk", c.stated->accelerometer_random_walk},
                      {"gyroscope_noise_density", c.stated->gyroscope_noise_density},
                      {"gyroscope_random_walk", c.stated->gyroscope_random_walk}};
  }
  json["conventions"] =
      "two-sided densities in continuous time: a sample at the rate f has the sigma density * "
      "sqrt(f), and a bias changes by random_walk * sqrt(seconds); instability: the flat Allan "
      "deviation is 0.664 of it; sigma: 68 %; limit: 95 %, one-sided";
  json["remarks"] = c.remarks;
  return json;
}

std::string noise_text(const NoiseCalibration& c) {
  std::string text = head_text(c);
  for (const Sensor& sensor : kSensors) {
    const auto axis = [](std::size_t i) { return std::string(kAxes[i % 3]); };
    text += "\n";
    text += row(sensor.name, sensor.first, axis, "a filter takes");
    text += standstill_rows(c, sensor) + motion_rows(c, sensor);
  }
  if (c.stated) {
    text += fmt::format(
        "\nThe recording states {:.3g} {} and {:.3g} {}, walks {:.3g} and {:.3g}.\n",
        c.stated->accelerometer_noise_density, "m/s^2/sqrt(Hz)", c.stated->gyroscope_noise_density,
        "rad/s/sqrt(Hz)", c.stated->accelerometer_random_walk, c.stated->gyroscope_random_walk);
  }
  for (const std::string& remark : c.remarks) text += "note: " + remark + "\n";
  return text;
}

std::string noise_yaml(const NoiseCalibration& c) {
  std::string text = fmt::format(
      "# Measured by chasles calibrate noise: {:.0f} s of standstill{}. Continuous time, the root "
      "mean\n"
      "# square of the axes. Kalibr reads this file, and the keys are those of calibration.yaml.\n"
      "rostopic: /imu0\nupdate_rate: {:.6g}\n",
      c.standstill_seconds(), c.standstill ? "" : ", densities from a motion", c.rate);
  for (const Sensor& sensor : kSensors) {
    const TakenNoise density = c.density(sensor.first);
    text += fmt::format("{}_noise_density: {:.6g}{}\n", sensor.name, density.value,
                        density.is_limit ? "  # at most" : "");
    text += walk_line(c, sensor);
  }
  return text;
}

std::string allan_csv(const NoiseCalibration& c) {
  std::string text = "axis,tau_s,deviation,low,high,fit,dof,differences\n";
  if (!c.standstill) return text;
  for (std::size_t i = 0; i < kImuSignals; ++i) {
    for (const AllanPoint& p : (*c.standstill)[i].allan) {
      text +=
          fmt::format("{}_{},{},{},{},{},{},{},{}\n", kSensors[i / 3].name, kAxes[i % 3], p.seconds,
                      p.deviation, p.lowest, p.highest, p.of_fit, p.dof, p.differences);
    }
  }
  return text;
}

}  // namespace chasles
