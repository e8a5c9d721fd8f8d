#include <array>
#include <string>

#include <Eigen/LU>

#include <chasles/error.hpp>
#include <chasles/filter/error_chart.hpp>

namespace chasles {
namespace {

using MotionBlock = Eigen::Matrix<double, 9, 9>;

// Rows of pose and v_world: 6 or 9.
int motion_size(const State& x) { return x.additive_row(); }

}  // namespace

std::span<const ErrorChart> error_charts() {
  static const std::array charts{kStandardChart, kLeftSe3Chart, kRightSe3Chart, kRightSen3Chart};
  return charts;
}

const ErrorChart& error_chart(std::string_view name) {
  std::string names;
  for (const ErrorChart& chart : error_charts()) {
    if (chart.name == name) return chart;
    names += (names.empty() ? "" : ", ") + std::string(chart.name);
  }
  throw UsageError("no error chart is called '" + std::string(name) + "'; there are " + names);
}

void push(const ErrorChart& chart, const State& x, Eigen::Ref<Eigen::MatrixXd> M) {
  if (chart.landmark_block) {
    for (const Landmark& landmark : x.landmarks) {
      M.middleRows<3>(landmark.row) += chart.landmark_block(landmark.p_world) * M.topRows<3>();
    }
  }
  const int n = motion_size(x);
  const MotionBlock T = chart.motion_block(x);
  M.topRows(n) = (T.topLeftCorner(n, n) * M.topRows(n)).eval();
}

void pull(const ErrorChart& chart, const State& x, Eigen::Ref<Eigen::MatrixXd> M) {
  const int n = motion_size(x);
  const MotionBlock T = chart.motion_block(x);
  M.topRows(n) = T.topLeftCorner(n, n).partialPivLu().solve(M.topRows(n)).eval();
  if (chart.landmark_block) {
    for (const Landmark& landmark : x.landmarks) {
      M.middleRows<3>(landmark.row) -= chart.landmark_block(landmark.p_world) * M.topRows<3>();
    }
  }
}

Eigen::MatrixXd in_chart(const ErrorChart& chart, const Eigen::MatrixXd& F, const State& x,
                         const State& next) {
  Eigen::MatrixXd result = F;
  push(chart, next, result);
  // F T^-1 = (T^-T F^T)^T; T^-1 itself is small enough to be formed by pulling the identity.
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(F.cols(), F.cols());
  pull(chart, x, inverse);
  return result * inverse;
}

}  // namespace chasles
