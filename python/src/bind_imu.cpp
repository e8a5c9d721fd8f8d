#include <utility>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <chasles/recording/split_imu.hpp>

#include "arrays.hpp"
#include "module.hpp"
#include "recordings.hpp"

namespace chasles::python {
namespace {

SensorStream stream_of(const char* name, const py::array& time, const Rows& values) {
  const std::vector<Time> times = times_of(time);
  const auto n = static_cast<Eigen::Index>(times.size());
  if (values.rows() != n || values.cols() != 3) {
    throw py::value_error(
        fmt::format("join_imu: found {} times and values {} x {} of the {}, "
                    "expected (N,) and (N, 3)",
                    n, values.rows(), values.cols(), name));
  }
  SensorStream stream{.name = name, .samples = {}};
  for (Eigen::Index i = 0; i < n; ++i) {
    stream.samples.push_back({.time = times[static_cast<std::size_t>(i)], .value = values.row(i)});
  }
  return stream;
}

py::dict join_imu(const py::array& gyro_time, const Rows& angular_rate, const py::array& accel_time,
                  const Rows& specific_force) {
  Recording joined;
  join_streams("join_imu", stream_of("accelerometer", accel_time, specific_force),
               stream_of("gyroscope", gyro_time, angular_rate), Eigen::Matrix3d::Identity(),
               joined);
  py::dict result = imu_columns(joined.imu);
  result["remarks"] = joined.remarks;
  return result;
}

}  // namespace

py::dict imu_columns(std::span<const ImuSample> imu) {
  const auto n = static_cast<Eigen::Index>(imu.size());
  Times times(n);
  Rows force(n, 3), rate(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ImuSample& sample = imu[static_cast<std::size_t>(i)];
    times[i] = sample.time.count();
    force.row(i) = sample.specific_force_imu;
    rate.row(i) = sample.angular_rate_imu;
  }
  py::dict result;
  result["time"] = std::move(times);
  result["specific_force"] = std::move(force);
  result["angular_rate"] = std::move(rate);
  return result;
}

void bind_imu(py::module_& m) {
  m.def("join_imu", &join_imu, py::arg("gyro_time"), py::arg("angular_rate"), py::arg("accel_time"),
        py::arg("specific_force"));
}

}  // namespace chasles::python
