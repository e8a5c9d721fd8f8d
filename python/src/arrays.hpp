#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <chasles/base/time.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/lie/trajectory.hpp>

// Between Python's objects and ours. An Eigen matrix that is returned becomes an array that owns
// it.
namespace chasles::python {

namespace py = pybind11;

using Times = Eigen::Matrix<std::int64_t, Eigen::Dynamic, 1>;  ///< [ns]
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// An int is in nanoseconds, a float in seconds. Throws TypeError for anything else, and ValueError
/// for a number that is no time, both beginning with `what`.
Time time_of(const py::handle& value, const std::string& what = "time");
/// The same of each element. Throws ValueError where the array is not one-dimensional.
std::vector<Time> times_of(const py::array& values, const std::string& what = "times");

/// The getter and the setter of a matrix. Python gets a copy: a view would change with the object,
/// and outlive its memory.
template <typename Object, typename Matrix>
auto copy_of(Matrix Object::*member) {
  return [member](const Object& object) { return Matrix(object.*member); };
}
template <typename Object, typename Matrix>
auto assign(Matrix Object::*member) {
  return [member](Object& object, const Matrix& value) { object.*member = value; };
}

/// What an object is, for messages: arrays by their shapes.
std::string description(const py::handle& object);

/// The object as a T. Where it is none, throws TypeError: `found`, the description, `expected`.
template <typename T>
T as(const py::handle& object, const std::string& found, const std::string& expected) {
  try {
    return object.cast<T>();
  } catch (const py::cast_error&) {
  } catch (const py::reference_cast_error&) {  // None where a class is expected
  }
  throw py::type_error(found + " " + description(object) + ", expected " + expected);
}

/// x y z w, as ROS and TUM have it.
Eigen::Vector4d quaternion_xyzw(const Eigen::Matrix3d& R);
Eigen::Matrix4d matrix(const SE3& pose);
/// Throws ValueError, beginning with `what`, where the 4 x 4 matrix is no rigid transformation.
SE3 pose_of(const Eigen::Matrix4d& matrix, const std::string& what);

/// {"time": (N,) int64 [ns], "position": (N, 3) [m], "quaternion": (N, 4) x y z w}
py::dict columns(const Trajectory& trajectory);
/// From (N,) times as ints [ns] or floats [s], positions and, if any, quaternions x y z w. Throws
/// InputError, beginning with `what`, for shapes that do not fit, times that do not rise, numbers
/// that are not finite and quaternions of length 0.
Trajectory trajectory_of(const std::string& what, const py::array& times, const Rows& positions,
                         const Rows& quaternions);

/// (N, rows * rows) as (N, rows, rows).
py::array cubes(Rows matrices, py::ssize_t rows);

/// {"id": (N,), "position": (N, 3) [m], "covariance": (N, 3, 3) [m^2], "observations": (N,)}
template <typename Landmark>
py::dict columns(const std::vector<Landmark>& landmarks) {
  const auto n = static_cast<Eigen::Index>(landmarks.size());
  Times ids(n), observations(n);
  Rows positions(n, 3), covariances(n, 9);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Landmark& landmark = landmarks[static_cast<std::size_t>(i)];
    ids[i] = landmark.id;
    observations[i] = landmark.observations;
    positions.row(i) = landmark.p_world;
    covariances.row(i) = landmark.covariance.template reshaped<Eigen::RowMajor>().transpose();
  }
  py::dict result;
  result["id"] = std::move(ids);
  result["position"] = std::move(positions);
  result["covariance"] = cubes(std::move(covariances), 3);
  result["observations"] = std::move(observations);
  return result;
}

/// A grey image of an array (height, width) of uint8, or of an image of Pillow, whose colours
/// become grey as those of files; empty for None. Throws ValueError, beginning with `what`, for
/// another object: the order of an array's colours is not known.
GrayImage image_of(const py::handle& object, const std::string& what = "image");
/// Whether it is an image of Pillow.
bool is_pillow_image(const py::handle& object);
py::array_t<std::uint8_t> array_of(GrayImage image);

/// Settings as the command takes them, key=value: nested dictionaries are prefixes, None is auto.
std::vector<std::string> assignments(const py::dict& settings, const std::string& prefix = "");

}  // namespace chasles::python
