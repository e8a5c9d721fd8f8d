#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/base/time.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

/// An array of numbers with a shape: a field of a file.
struct NumberArray {
  std::string where;               ///< "FILE: field 'NAME'", for messages
  std::vector<std::size_t> shape;  ///< empty: a single number
  std::vector<double> values;      ///< last index fastest
};

/// "(3, 1104)".
std::string shape_text(const std::vector<std::size_t>& shape);

/// The checks below throw InputError with the field, the index, the value found and the value
/// expected.

/// The only number of the array (shape (), (1), (1, 1), …), finite.
double checked_scalar(const NumberArray& array);

/// A matrix of exactly rows x cols finite numbers. `why` states the reason for the sizes.
Eigen::MatrixXd checked_matrix(const NumberArray& array, std::size_t rows, std::size_t cols,
                               const std::string& why);

/// The first `least` columns of a matrix with the given number of rows and at least `least`
/// columns.
Eigen::MatrixXd checked_columns(const NumberArray& array, std::size_t rows, std::size_t least,
                                const std::string& why);

/// Times from seconds, of shape (T), (1, T) or (T, 1); they must rise strictly.
std::vector<Time> checked_times(const NumberArray& array);

/// Throws unless R is a rotation within 1e-3 (a matrix may be printed with few digits). Returns it
/// with round-off removed. `where` names the field.
Eigen::Matrix3d checked_rotation(const std::string& where, const Eigen::Matrix3d& R);

/// Throws unless M is a rigid motion [R | p; 0 0 0 1].
SE3 checked_motion(const std::string& where, const Eigen::Matrix4d& M);

/// The unit quaternion (x, y, z, w) of a rotation, with w >= 0.
Eigen::Vector4d unit_quaternion(const Eigen::Matrix3d& R);

/// The rotation of a quaternion (x, y, z, w). Throws unless its length is 1 within 1e-3.
Eigen::Matrix3d checked_quaternion(const std::string& where, const Eigen::Vector4d& xyzw);

/// Throws unless the number is positive and finite.
double checked_positive(const std::string& where, double value);

/// Throws unless `time` is later than `before`. `where` names the row.
void check_rises(const std::string& where, Time before, Time time);

}  // namespace chasles
