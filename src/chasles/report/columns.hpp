#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include <chasles/lie/trajectory.hpp>
#include <chasles/report/encode.hpp>

// Columns of the pages' data, built from rows.
namespace chasles {

/// One value per row.
template <typename Value, typename Rows, typename Of>
std::vector<Value> values(const Rows& rows, const Of& of) {
  std::vector<Value> result;
  result.reserve(rows.size());
  for (const auto& row : rows) result.push_back(of(row));
  return result;
}

/// A column with one number per row.
template <typename Rows, typename Number>
std::string floats(const Rows& rows, const Number& number) {
  return float_column(values<double>(rows, number));
}

/// As floats(), of whole numbers.
template <typename Rows, typename Number>
std::string ints(const Rows& rows, const Number& number) {
  return int_column(values<int>(rows, number));
}

/// x, y, z (with an optional prefix) of the rows' points.
template <typename Rows, typename Point>
void add_points(nlohmann::ordered_json& columns, const std::string& prefix, const Rows& rows,
                const Point& point) {
  for (const auto& [axis, k] : {std::pair{"x", 0}, {"y", 1}, {"z", 2}}) {
    columns[prefix + axis] =
        floats(rows, [&point, k = k](const auto& row) -> double { return point(row)(k); });
  }
}

/// cxx, cxy, …: the six numbers of the rows' symmetric 3x3 matrices.
template <typename Rows, typename Matrix>
void add_covariances(nlohmann::ordered_json& columns, const Rows& rows, const Matrix& matrix) {
  const std::string axes = "xyz";
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      const std::string name{'c', axes[static_cast<std::size_t>(i)],
                             axes[static_cast<std::size_t>(j)]};
      columns[name] = floats(rows, [&](const auto& row) { return matrix(row)(i, j); });
    }
  }
}

/// Every n-th row, at most about `enough` rows; more do not improve the drawing of a path.
template <typename Row>
std::vector<Row> thinned(const std::vector<Row>& rows, std::size_t enough = 4000) {
  const std::size_t stride = rows.size() / enough + 1;
  std::vector<Row> thin;
  for (std::size_t i = 0; i < rows.size(); i += stride) thin.push_back(rows[i]);
  return thin;
}

}  // namespace chasles
