#include "arrays.hpp"

#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

#include <chasles/lie/so3.hpp>

namespace chasles::python {

using Eigen::Index;

Time time_of(const py::handle& value) {
  if (PyFloat_Check(value.ptr())) {
    constexpr double kMost = 9.2e9;  // 64 bits of nanoseconds
    const double seconds = value.cast<double>();
    if (std::abs(seconds) < kMost) return from_seconds(seconds);
    throw py::value_error(fmt::format(
        "time: found {} as a float, which is in seconds; expected a finite number below {:g}. "
        "Nanoseconds are ints",
        seconds, kMost));
  }
  const auto whole = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!whole) {
    PyErr_Clear();
    throw py::type_error(fmt::format(
        "time: found an object of type {}, expected an int, in nanoseconds, or a float, in seconds",
        Py_TYPE(value.ptr())->tp_name));
  }
  const std::int64_t nanoseconds = PyLong_AsLongLong(whole.ptr());
  if (nanoseconds == -1 && PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    throw py::value_error(fmt::format("time: found {} ns, expected a number of 64 bits",
                                      py::str(whole).cast<std::string>()));
  }
  return Time(nanoseconds);
}

std::vector<Time> times_of(const py::array& values) {
  if (values.ndim() != 1) {
    throw py::value_error(
        fmt::format("times: found {} dimensions, expected an array (N,)", values.ndim()));
  }
  std::vector<Time> times;
  for (const py::handle& value : values) times.push_back(time_of(value));
  return times;
}

std::string description(const py::handle& object) {
  if (py::isinstance<py::array>(object)) {
    return "an array " + py::str(object.attr("shape")).cast<std::string>();
  }
  if (!py::isinstance<py::tuple>(object)) return py::repr(object).cast<std::string>();
  std::string elements;
  for (const py::handle& one : object) {
    elements += (elements.empty() ? "" : ", ") + description(one);
  }
  return "(" + elements + ")";
}

Eigen::Vector4d quaternion_xyzw(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  return q.coeffs();
}

Eigen::Matrix4d matrix(const SE3& pose) {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = pose.R;
  T.topRightCorner<3, 1>() = pose.p;
  return T;
}

SE3 pose_of(const Eigen::Matrix4d& matrix) {
  const Eigen::Matrix3d R = matrix.topLeftCorner<3, 3>();
  const bool is_rotation = (R * R.transpose()).isIdentity(1e-6) && R.determinant() > 0;
  if (!matrix.allFinite() || !is_rotation || matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    throw py::value_error(
        "pose: expected a 4 x 4 matrix [R p; 0 0 0 1] with a rotation matrix R (to 1e-6)");
  }
  return {.R = so3::normalized(R), .p = matrix.topRightCorner<3, 1>()};
}

py::dict columns(const Trajectory& trajectory) {
  const auto n = static_cast<Index>(trajectory.size());
  Times times(n);
  Rows positions(n, 3), quaternions(n, 4);
  for (Index i = 0; i < n; ++i) {
    const StampedPose& stamped = trajectory[static_cast<std::size_t>(i)];
    times[i] = stamped.time.count();
    positions.row(i) = stamped.pose.p;
    quaternions.row(i) = quaternion_xyzw(stamped.pose.R);
  }
  py::dict result;
  result["time"] = std::move(times);
  result["position"] = std::move(positions);
  result["quaternion"] = std::move(quaternions);
  return result;
}

Trajectory trajectory_of(const py::array& times, const Rows& positions, const Rows& quaternions) {
  const bool has_attitude = quaternions.size() > 0;
  if (times.ndim() != 1 || positions.cols() != 3 || positions.rows() != times.shape(0) ||
      (has_attitude && (quaternions.cols() != 4 || quaternions.rows() != times.shape(0)))) {
    throw py::value_error(fmt::format(
        "trajectory: found {} times, positions {} x {} and quaternions {} x {}; expected "
        "(N,), (N, 3) and (N, 4)",
        times.size(), positions.rows(), positions.cols(), quaternions.rows(), quaternions.cols()));
  }
  Trajectory trajectory;
  Index row = 0;
  for (const Time time : times_of(times)) {
    StampedPose stamped{.time = time, .pose = {}};
    stamped.pose.p = positions.row(row);
    if (has_attitude) {
      const Eigen::Vector4d q = quaternions.row(row);
      stamped.pose.R = Eigen::Quaterniond(q).normalized().toRotationMatrix();
    }
    if (!stamped.pose.p.allFinite() || !stamped.pose.R.allFinite()) {
      throw py::value_error(fmt::format("trajectory: row {} is not finite", row));
    }
    if (!trajectory.empty() && stamped.time <= trajectory.back().time) {
      throw py::value_error(fmt::format(
          "trajectory: the time of row {} is not later than that of the row before", row));
    }
    trajectory.push_back(stamped);
    ++row;
  }
  return trajectory;
}

py::array cubes(Rows matrices, py::ssize_t rows) {
  const auto n = static_cast<py::ssize_t>(matrices.rows());
  return py::array(py::cast(std::move(matrices))).reshape({n, rows, rows});
}

GrayImage image_of(const py::handle& object) {
  if (object.is_none()) return {};
  const auto array = py::array::ensure(object);
  if (!array || array.ndim() != 2 || !py::isinstance<py::array_t<std::uint8_t>>(array)) {
    throw py::value_error(
        "image: expected a two-dimensional array (height, width) of uint8, or None for a camera "
        "without an image");
  }
  const auto rows = py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>(array);
  GrayImage image;
  image.width = static_cast<int>(rows.shape(1));
  image.height = static_cast<int>(rows.shape(0));
  image.pixels.assign(rows.data(), rows.data() + rows.size());
  return image;
}

py::array_t<std::uint8_t> array_of(GrayImage image) {
  auto owner = std::make_unique<GrayImage>(std::move(image));
  const std::uint8_t* const pixels = owner->pixels.data();
  const std::array<py::ssize_t, 2> shape{owner->height, owner->width};
  const py::capsule base(owner.release(), [](void* p) { delete static_cast<GrayImage*>(p); });
  return py::array_t<std::uint8_t>(shape, pixels, base);
}

std::vector<std::string> assignments(const py::dict& settings, const std::string& prefix) {
  std::vector<std::string> result;
  for (const auto& [key, value] : settings) {
    const std::string name = prefix + py::str(key).cast<std::string>();
    if (py::isinstance<py::dict>(value)) {
      for (std::string& one : assignments(value.cast<py::dict>(), name + ".")) {
        result.push_back(std::move(one));
      }
      continue;
    }
    std::string text;
    if (value.is_none()) {
      text = "auto";
    } else if (py::isinstance<py::bool_>(value)) {
      text = value.cast<bool>() ? "true" : "false";
    } else if (PyFloat_Check(value.ptr())) {
      text = py::repr(py::float_(value.cast<double>())).cast<std::string>();
    } else {
      text = py::str(value).cast<std::string>();
    }
    result.push_back(name + "=" + text);
  }
  return result;
}

}  // namespace chasles::python
