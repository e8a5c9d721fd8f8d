#pragma once

#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/lie/so3.hpp>

/// Shared by the .cpp files of the charts; not included elsewhere.
namespace chasles::chart_detail {

using MotionBlock = Eigen::Matrix<double, 9, 9>;

inline void add_additive(State& x, const ErrorRef& xi) {
  x.additive += xi.segment(x.additive_row(), x.additive.size());
}

inline void add_landmarks(State& x, const ErrorRef& xi) {
  for (Landmark& landmark : x.landmarks) landmark.parameters() += xi.segment<3>(landmark.row);
}

/// y - x for all additive parts; the rows of the rotation are zero.
inline Eigen::VectorXd differences(const State& x, const State& y) {
  Eigen::VectorXd xi = Eigen::VectorXd::Zero(x.size());
  xi.segment<3>(3) = y.world_T_imu.p - x.world_T_imu.p;
  if (x.v_world) xi.segment<3>(6) = *y.v_world - *x.v_world;
  xi.segment(x.additive_row(), x.additive.size()) = y.additive - x.additive;
  for (std::size_t i = 0; i < x.landmarks.size(); ++i) {
    xi.segment<3>(x.landmarks[i].row) = y.landmarks[i].parameters() - x.landmarks[i].parameters();
  }
  return xi;
}

}  // namespace chasles::chart_detail
