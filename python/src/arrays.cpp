#include "arrays.hpp"

#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/image_kinds.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles::python {

using Eigen::Index;

Time time_of(const py::handle& value, const std::string& what) {
  if (PyFloat_Check(value.ptr())) {
    constexpr double kMost = 9.2e9;  // 64 bits of nanoseconds
    const double seconds = value.cast<double>();
    if (std::abs(seconds) < kMost) return from_seconds(seconds);
    throw py::value_error(fmt::format(
        "{}: found {} as a float, which is in seconds; expected a finite number below {:g}. "
        "Nanoseconds are ints",
        what, seconds, kMost));
  }
  const auto whole = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!whole) {
    PyErr_Clear();
    throw py::type_error(fmt::format(
        "{}: found an object of type {}, expected an int, in nanoseconds, or a float, in seconds",
        what, Py_TYPE(value.ptr())->tp_name));
  }
  const std::int64_t nanoseconds = PyLong_AsLongLong(whole.ptr());
  if (nanoseconds == -1 && PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    throw py::value_error(fmt::format("{}: found {} ns, expected a number of 64 bits", what,
                                      py::str(whole).cast<std::string>()));
  }
  return Time(nanoseconds);
}

std::vector<Time> times_of(const py::array& values, const std::string& what) {
  if (values.ndim() != 1) {
    throw py::value_error(fmt::format("{}: found {} of {} dimensions, expected an array (N,)", what,
                                      py::str(values.dtype()).cast<std::string>(), values.ndim()));
  }
  std::vector<Time> times;
  for (const py::handle& value : values) times.push_back(time_of(value, what));
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

SE3 pose_of(const Eigen::Matrix4d& matrix, const std::string& what) {
  const Eigen::Matrix3d R = matrix.topLeftCorner<3, 3>();
  const bool is_rotation = (R * R.transpose()).isIdentity(1e-6) && R.determinant() > 0;
  if (!matrix.allFinite() || !is_rotation || matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    throw py::value_error(fmt::format(
        "{}: found R with det(R) = {:.6g}, |R R^T - 1| = {:.2g} and the last row {:g} {:g} {:g} "
        "{:g}; expected a 4 x 4 matrix [R p; 0 0 0 1] with a rotation matrix R (to 1e-6)",
        what, R.determinant(), (R * R.transpose() - Eigen::Matrix3d::Identity()).norm(),
        matrix(3, 0), matrix(3, 1), matrix(3, 2), matrix(3, 3)));
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

namespace {

void check_row(const std::string& what, Index row, const StampedPose& stamped,
               const Trajectory& before) {
  if (!stamped.pose.p.allFinite() || !stamped.pose.R.allFinite()) {
    throw InputError(fmt::format(
        "{}: row {} is not finite (NaN or infinite); expected numbers, leave such rows out", what,
        row));
  }
  if (!before.empty() && stamped.time <= before.back().time) {
    throw InputError(
        fmt::format("{}: row {} has the time {} ns, after {} ns; expected times that rise", what,
                    row, stamped.time.count(), before.back().time.count()));
  }
}

}  // namespace

Trajectory trajectory_of(const std::string& what, const py::array& times, const Rows& positions,
                         const Rows& quaternions) {
  const bool has_attitude = quaternions.size() > 0;
  if (times.ndim() != 1 || positions.cols() != 3 || positions.rows() != times.shape(0) ||
      (has_attitude && (quaternions.cols() != 4 || quaternions.rows() != times.shape(0)))) {
    throw InputError(
        fmt::format("{}: found {} times, positions {} x {} and quaternions {} x {}; expected "
                    "(N,), (N, 3) and (N, 4)",
                    what, times.size(), positions.rows(), positions.cols(), quaternions.rows(),
                    quaternions.cols()));
  }
  Trajectory trajectory;
  Index row = 0;
  for (const Time time : times_of(times, what + ": time")) {
    StampedPose stamped{.time = time, .pose = {}};
    stamped.pose.p = positions.row(row);
    if (has_attitude) {
      constexpr double kLeast = 1e-6;
      const Eigen::Vector4d q = quaternions.row(row);
      if (q.norm() < kLeast) {
        throw InputError(fmt::format(
            "{}: row {} has a quaternion of length 0, as lost poses have; leave such rows out",
            what, row));
      }
      stamped.pose.R = Eigen::Quaterniond(q).normalized().toRotationMatrix();
    }
    check_row(what, row++, stamped, trajectory);
    trajectory.push_back(stamped);
  }
  return trajectory;
}

py::array cubes(Rows matrices, py::ssize_t rows) {
  const auto n = static_cast<py::ssize_t>(matrices.rows());
  return py::array(py::cast(std::move(matrices))).reshape({n, rows, rows});
}

namespace {

constexpr const char* kExpectedImage =
    "expected grey (height, width) of uint8, an image of Pillow, or None for a camera without an "
    "image";

// What an array that is no grey image has too much, and what makes one.
std::string remedy(const py::array& array) {
  const bool bytes = array.dtype().kind() == 'u' && array.dtype().itemsize() == 1;
  if (array.ndim() == 3 && (array.shape(2) == 3 || array.shape(2) == 4)) {
    return "; the order of the colours is not known: cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) where "
           "blue is first, PIL.Image.fromarray(image) where red is";
  }
  if (array.ndim() == 2 && !bytes) {
    return "; (255 * image / image.max()).astype(numpy.uint8) makes one, with the same largest "
           "value for all images";
  }
  return "";
}

GrayImage grey_of_bytes(const py::handle& array) {
  const auto rows = py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>(
      py::reinterpret_borrow<py::object>(array));
  GrayImage image;
  image.width = static_cast<int>(rows.shape(1));
  image.height = static_cast<int>(rows.shape(0));
  image.pixels.assign(rows.data(), rows.data() + rows.size());
  return image;
}

GrayImage grey_of_pillow(const py::handle& object, const std::string& what) {
  const auto mode = object.attr("mode").cast<std::string>();
  const py::object numpy = py::module_::import("numpy");
  if (mode == "L") return grey_of_bytes(numpy.attr("asarray")(object));
  if (mode.starts_with("I") || mode == "F") {
    throw py::value_error(fmt::format(
        "{}: found an image of Pillow of mode {}, expected one of 8 bits: L, RGB, RGBA, P", what,
        mode));
  }
  const py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast> colours =
      numpy.attr("asarray")(object.attr("convert")("RGB"));
  GrayImage image;
  image.width = static_cast<int>(colours.shape(1));
  image.height = static_cast<int>(colours.shape(0));
  for (const std::uint8_t* p = colours.data(); p != colours.data() + colours.size(); p += 3) {
    image.pixels.push_back(static_cast<std::uint8_t>(grey_of_colour(p[0], p[1], p[2])));
  }
  return image;
}

}  // namespace

bool is_pillow_image(const py::handle& object) {
  return !py::isinstance<py::array>(object) && py::hasattr(object, "getbands") &&
         py::hasattr(object, "convert");
}

GrayImage image_of(const py::handle& object, const std::string& what) {
  if (object.is_none()) return {};
  if (is_pillow_image(object)) return grey_of_pillow(object, what);
  const auto array = py::array::ensure(object);  // of a tensor or a memoryview, too
  if (!array || array.ndim() == 0) {
    throw py::value_error(fmt::format("{}: found an object of type {}; {}", what,
                                      Py_TYPE(object.ptr())->tp_name, kExpectedImage));
  }
  if (array.ndim() == 2 && py::isinstance<py::array_t<std::uint8_t>>(array)) {
    return grey_of_bytes(array);
  }
  throw py::value_error(fmt::format("{}: found {} of {}; {}{}", what, description(array),
                                    py::str(array.dtype()).cast<std::string>(), kExpectedImage,
                                    remedy(array)));
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
