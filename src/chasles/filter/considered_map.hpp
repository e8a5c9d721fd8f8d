#pragma once

#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/filter/covariance.hpp>
#include <chasles/filter/past/past.hpp>
#include <chasles/filter/state.hpp>
#include <chasles/filter/whitening.hpp>

/// A map that no update changes, x.considered: the Schmidt-Kalman filter (docs/filter.md). `left`:
/// the states that have left the filter; it has the map as it was added.
namespace chasles {

/// Numbers of past states: the others, and those of a considered map.
std::pair<std::vector<int>, std::vector<int>> apart_from_considered(const State& x,
                                                                    const Past& left,
                                                                    std::span<const int> numbers);

/// The position of one of its landmarks, in the axes of the filter's map.
Eigen::Vector3d considered_place(const State& x, const Past& left, int number);

/// The correction delta of an update moves the frame of the map, and its landmarks with it.
void put_considered_in_place(const Past& left, const ErrorRef& delta, State& x);

/// The part D of the gain that an update does not use, as it would correct a considered map: P is
/// larger by D D^T, and D w is not corrected. `rows` are those of D in the error vector.
struct UnusedGain {
  std::vector<int> rows;
  Eigen::MatrixXd D;
};
UnusedGain unused_gain(const State& x, const Past& left, const Whitened& z);

/// Past states of a considered map as linear functions of the errors of the state, with errors of
/// their own and the corrections of their means.
struct OfState {
  std::vector<Segment::Item> items;
  Eigen::MatrixXd d, own;
  Eigen::VectorXd correction;
};
OfState considered_of_state(const State& x, const Past& left, std::span<const int> numbers,
                            Eigen::Index size);

/// Such states together with other past states, in the order of their numbers.
Carried with_considered(const Carried& others, const OfState& of_state,
                        const Covariance& covariance);

/// The landmarks of a considered map that are not in the state.
std::vector<MapLandmark> considered_landmarks(const State& x, const Past& left,
                                              const Covariance& covariance);

}  // namespace chasles
