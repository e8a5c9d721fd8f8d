#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/parse.hpp>

namespace chasles {
namespace {

constexpr double kUnitTolerance = 1e-3;

std::string index_text(const std::vector<std::size_t>& shape, std::size_t flat) {
  std::vector<std::size_t> index(shape.size());
  for (std::size_t axis = shape.size(); axis-- > 0;) {
    index[axis] = flat % shape[axis];
    flat /= shape[axis];
  }
  return fmt::format("[{}]", fmt::join(index, ", "));
}

void check_finite(const NumberArray& array) {
  for (std::size_t i = 0; i < array.values.size(); ++i) {
    if (std::isfinite(array.values[i])) continue;
    throw InputError(fmt::format("{}: value {} at index {}, expected finite numbers", array.where,
                                 array.values[i], index_text(array.shape, i)));
  }
}

[[noreturn]] void fail_shape(const NumberArray& array, const std::string& expected) {
  throw InputError(
      fmt::format("{}: has shape {}, expected {}", array.where, shape_text(array.shape), expected));
}

}  // namespace

std::string shape_text(const std::vector<std::size_t>& shape) {
  return fmt::format("({})", fmt::join(shape, ", "));
}

double checked_scalar(const NumberArray& array) {
  if (array.values.size() != 1) fail_shape(array, "a single number");
  check_finite(array);
  return array.values.front();
}

Eigen::MatrixXd checked_matrix(const NumberArray& array, std::size_t rows, std::size_t cols,
                               const std::string& why) {
  if (array.shape != std::vector{rows, cols}) {
    fail_shape(array, fmt::format("({}, {}) ({})", rows, cols, why));
  }
  check_finite(array);
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const RowMajor>(array.values.data(), static_cast<Eigen::Index>(rows),
                                    static_cast<Eigen::Index>(cols));
}

Eigen::MatrixXd checked_columns(const NumberArray& array, std::size_t rows, std::size_t least,
                                const std::string& why) {
  if (array.shape.size() != 2 || array.shape[0] != rows || array.shape[1] < least) {
    fail_shape(array, fmt::format("({}, at least {}) ({})", rows, least, why));
  }
  return checked_matrix(array, rows, array.shape[1], why)
      .leftCols(static_cast<Eigen::Index>(least));
}

std::vector<Time> checked_times(const NumberArray& array) {
  const std::size_t count = array.values.size();
  const bool line = array.shape.size() == 1 ||
                    (array.shape.size() == 2 && (array.shape[0] == 1 || array.shape[1] == 1));
  if (!line || count == 0) fail_shape(array, "(1, T): the T time stamps of the recording");
  check_finite(array);
  std::vector<Time> times;
  times.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double seconds = array.values[i];
    if (!(std::abs(seconds) < static_cast<double>(kLastSecond))) {
      throw InputError(fmt::format("{}: value {} at index {}, expected seconds below {}",
                                   array.where, seconds, index_text(array.shape, i), kLastSecond));
    }
    times.push_back(from_seconds(seconds));
    if (i > 0)
      check_rises(fmt::format("{}: index {}", array.where, index_text(array.shape, i)),
                  times[i - 1], times[i]);
  }
  return times;
}

Eigen::Matrix3d checked_rotation(const std::string& where, const Eigen::Matrix3d& R) {
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error <= 1e-3)) {
    throw InputError(fmt::format(
        "{}: the 3x3 part is not a rotation: R^T R differs from the identity by {:.3g}, expected "
        "at most 0.001",
        where, error));
  }
  if (R.determinant() < 0) {
    throw InputError(
        fmt::format("{}: the 3x3 part is a reflection (determinant {:.6g}), expected a rotation "
                    "(determinant +1): is an axis of one frame flipped?",
                    where, R.determinant()));
  }
  return error <= 1e-12 ? R : so3::normalized(R);
}

SE3 checked_motion(const std::string& where, const Eigen::Matrix4d& M) {
  if (!M.allFinite()) throw InputError(where + ": is not finite");
  if (M.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    throw InputError(fmt::format("{}: the last row is ({}, {}, {}, {}), expected (0, 0, 0, 1)",
                                 where, M(3, 0), M(3, 1), M(3, 2), M(3, 3)));
  }
  return {checked_rotation(where, M.topLeftCorner<3, 3>()), M.topRightCorner<3, 1>()};
}

Eigen::Vector4d unit_quaternion(const Eigen::Matrix3d& R) {
  const Eigen::Vector4d xyzw = Eigen::Quaterniond(R).coeffs();
  return xyzw[3] < 0 ? Eigen::Vector4d(-xyzw) : xyzw;
}

Eigen::Matrix3d checked_quaternion(const std::string& where, const Eigen::Vector4d& xyzw) {
  if (std::abs(xyzw.norm() - 1) <= kUnitTolerance) {
    return Eigen::Quaterniond(xyzw.normalized()).toRotationMatrix();
  }
  throw InputError(
      fmt::format("{}: the quaternion ({}, {}, {}, {}) has length {:.6g}, expected 1 "
                  "within {}",
                  where, xyzw[0], xyzw[1], xyzw[2], xyzw[3], xyzw.norm(), kUnitTolerance));
}

double checked_positive(const std::string& where, double value) {
  if (std::isfinite(value) && value > 0) return value;
  throw InputError(fmt::format("{}: is {}, expected a positive number", where, value));
}

void check_rises(const std::string& where, Time before, Time time) {
  if (time > before) return;
  throw InputError(fmt::format(
      "{}: the time {:.9f} s does not come after the one before it, {:.9f} s: expected times that "
      "rise strictly",
      where, to_seconds(time), to_seconds(before)));
}

}  // namespace chasles
