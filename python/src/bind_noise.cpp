#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/noise/imu_alone.hpp>
#include <chasles/calibrate/noise/noise_calibration.hpp>
#include <chasles/calibrate/noise/noise_output.hpp>
#include <chasles/codec/utf8.hpp>

#include "arrays.hpp"
#include "long_call.hpp"
#include "messages.hpp"
#include "module.hpp"

namespace chasles::python {
namespace {

// The columns of a signal's Allan deviation.
py::dict allan_columns(const StandstillSignal& signal) {
  const auto column = [&](auto member) {
    Eigen::VectorXd values(std::ssize(signal.allan));
    for (std::size_t i = 0; i < signal.allan.size(); ++i) {
      values[static_cast<Eigen::Index>(i)] = static_cast<double>(signal.allan[i].*member);
    }
    return values;
  };
  py::dict columns;
  columns["tau"] = column(&AllanPoint::seconds);
  columns["deviation"] = column(&AllanPoint::deviation);
  columns["low"] = column(&AllanPoint::lowest);
  columns["high"] = column(&AllanPoint::highest);
  columns["fit"] = column(&AllanPoint::of_fit);
  columns["dof"] = column(&AllanPoint::dof);
  columns["differences"] = column(&AllanPoint::differences);
  return columns;
}

py::dict allan_of_axes(const NoiseCalibration& calibration) {
  static constexpr std::array kNames = {"accelerometer_x", "accelerometer_y", "accelerometer_z",
                                        "gyroscope_x",     "gyroscope_y",     "gyroscope_z"};
  py::dict all;
  for (std::size_t i = 0; calibration.standstill && i < kImuSignals; ++i) {
    all[kNames[i]] = allan_columns((*calibration.standstill)[i]);
  }
  return all;
}

// JSON, text, imu.yaml, allan.csv, and the columns of the latter.
py::tuple calibrate(const Recording& recording, std::optional<double> start,
                    std::optional<double> stop, bool standstill) {
  NoiseCalibration calibration = LongCall()([&] {
    return calibrate_noise(recording, {.start = start, .stop = stop, .all_standstill = standstill});
  });
  for (std::string& remark : calibration.remarks) remark = in_python(remark);
  return py::make_tuple(json_text(noise_json(calibration)), noise_text(calibration),
                        noise_yaml(calibration), allan_csv(calibration),
                        allan_of_axes(calibration));
}

Recording recording_of_imu(const py::array& time, const Rows& specific_force,
                           const Rows& angular_rate) {
  const std::vector<Time> times = times_of(time);
  const auto n = static_cast<Eigen::Index>(times.size());
  if (specific_force.rows() != n || specific_force.cols() != 3 || angular_rate.rows() != n ||
      angular_rate.cols() != 3) {
    throw py::value_error(fmt::format(
        "calibrate_noise: found {} times, specific_force {} x {} and angular_rate {} x {}, "
        "expected "
        "(N,) and twice (N, 3)",
        n, specific_force.rows(), specific_force.cols(), angular_rate.rows(), angular_rate.cols()));
  }
  Recording recording;
  recording.name = "arrays";
  for (Eigen::Index i = 0; i < n; ++i) {
    recording.imu.push_back({.time = times[static_cast<std::size_t>(i)],
                             .specific_force_imu = specific_force.row(i),
                             .angular_rate_imu = angular_rate.row(i)});
  }
  return recording;
}

Recording imu_of_file(const std::filesystem::path& path) {
  return LongCall()([&] { return read_for_imu(path); });
}

}  // namespace

void bind_noise(py::module_& m) {
  m.def("calibrate_noise", &calibrate, py::arg("recording"), py::arg("start"), py::arg("stop"),
        py::arg("standstill"));
  m.def("recording_of_imu", &recording_of_imu, py::arg("time"), py::arg("specific_force"),
        py::arg("angular_rate"));
  m.def("read_for_imu", &imu_of_file, py::arg("path"));
}

}  // namespace chasles::python
