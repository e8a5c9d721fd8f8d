#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <chasles/filter/covariance.hpp>
#include <chasles/filter/past/history.hpp>
#include <chasles/filter/past/kept_past.hpp>
#include <chasles/filter/past/past.hpp>
#include <chasles/filter/state.hpp>

namespace chasles {

/// A filter's past as it is known now. It refers to the filter: valid until the filter's next step.
class PastView {
 public:
  PastView(const KeptPast& kept, const State& state, const Covariance& covariance)
      : kept_(kept), state_(state), covariance_(covariance) {}

  /// Number of past states (landmarks, poses and frames of prior maps); their numbers rise from 0.
  int states() const { return kept_.left().states(); }
  /// A past landmark as it left.
  const Landmark& landmark(int number) const { return kept_.left().landmark(number); }
  /// A prior map, as it was added, by the number of its frame.
  const PriorMap& prior(int frame) const { return kept_.left().prior(frame); }
  /// Whether it is a landmark of a prior map that has not yet returned.
  bool follows(int number) const { return kept_.left().follows(number); }
  /// Memory of what the estimates are computed from.
  std::size_t bytes() const { return kept_.left().bytes() + kept_.history().bytes(); }

  /// Past landmarks (their numbers, rising) with all that is known now: their covariance, that with
  /// the errors of the state, and the corrections of their means since they left. Requires
  /// past.recalls.
  Carried recall(std::span<const int> numbers) const;
  /// The same, and the landmarks of the state (indices) in the axes of the map after them: items
  /// with the number -1, whose corrections are their positions.
  Carried recall(std::span<const int> numbers, std::span<const int> landmarks) const;

  /// The estimates of all past states and of the landmarks in the state, given all measurements.
  /// With Map::kPast it requires past.records.
  Past::Estimates estimates() const;

  /// Number of landmarks in the whole map: retired ones and those in the state. Landmarks with a
  /// non-positive inverse depth have no position and do not count.
  int map_size() const;

  /// The current estimate of the whole map: retired landmarks in the order of retirement, then
  /// those of the state; with Map::kPast and kDense in nav axes where nav_T_world is a state, else
  /// in world axes. The computing time is proportional to the length of the history.
  std::vector<MapLandmark> map() const { return estimates().landmarks; }

  /// The covariance of the whole map in the order of map(), 3 rows each, followed by the core, by
  /// block rows of the lower triangle: visit(r, block) has rows r … r + block.rows() of the columns
  /// 0 … r + block.rows(). The visitor decides what to store: the lower triangle for 8,000
  /// landmarks takes 2.3 GB. Throws UsageError where a bound on the memory has removed steps.
  void visit_map_covariance(const History::RowVisitor& visit) const;

 private:
  void visit_dense_covariance(const History::RowVisitor& visit) const;

  const KeptPast& kept_;
  const State& state_;
  const Covariance& covariance_;
};

}  // namespace chasles
