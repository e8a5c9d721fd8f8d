#include <algorithm>
#include <array>
#include <cmath>

#include <chasles/lie/small_matrices.hpp>
#include <chasles/smooth/batch/observability.hpp>

namespace chasles {
namespace {

constexpr int kSize = 11;
constexpr std::array<int, kSize> kRows = {0, 1, 6, 7, 8, 9, 10, 11, 12, 13, 14};
constexpr std::array<double, kSize> kUnits = {0.1, 0.1, 1, 1, 1, 1, 1, 1, 0.1, 0.1, 0.1};
constexpr std::array<const char*, kSize> kNames = {"roll",
                                                   "pitch",
                                                   "velocity x",
                                                   "velocity y",
                                                   "velocity z",
                                                   "accelerometer bias x",
                                                   "accelerometer bias y",
                                                   "accelerometer bias z",
                                                   "gyroscope bias x",
                                                   "gyroscope bias y",
                                                   "gyroscope bias z"};
constexpr double kNamed = 0.4;  // of the largest component

using Vector11d = Eigen::Matrix<double, kSize, 1>;
using Matrix11d = Eigen::Matrix<double, kSize, kSize>;

Matrix15d inverse(const Matrix15d& P) {
  const Eigen::Matrix<double, 15, 1> scale = P.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix15d unit = scale.asDiagonal() * P * scale.asDiagonal();
  return scale.asDiagonal() * inverse_symmetric(unit) * scale.asDiagonal();
}

std::string name_of(const Vector11d& direction) {
  std::array<int, kSize> order{};
  for (int i = 0; i < kSize; ++i) order[static_cast<std::size_t>(i)] = i;
  std::ranges::stable_sort(order, std::greater{}, [&](int i) { return std::abs(direction[i]); });
  std::string text;
  for (const int i : order) {
    if (std::abs(direction[i]) < kNamed * std::abs(direction[order.front()])) break;
    text += (text.empty() ? "" : i == order[1] ? " with " : ", ");
    text += kNames[static_cast<std::size_t>(i)];
  }
  return text;
}

}  // namespace

std::vector<std::string> unobservable_directions(const Matrix15d& posterior,
                                                 const Matrix15d& prior) {
  const Matrix15d data = inverse(posterior) - inverse(prior);
  Matrix11d information;
  for (int i = 0; i < kSize; ++i) {
    for (int j = 0; j < kSize; ++j) {
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      information(i, j) = kUnits[a] * kUnits[b] * data(kRows[a], kRows[b]);
    }
  }
  const SymmetricEigen eigen = symmetric_eigen((information + information.transpose()) / 2);
  std::vector<std::string> names;
  for (int i = 0; i < kSize; ++i) {
    if (eigen.values[i] < 1) names.push_back(name_of(eigen.vectors.col(i)));
  }
  return names;
}

}  // namespace chasles
