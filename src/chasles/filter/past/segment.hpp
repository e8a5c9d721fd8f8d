#pragma once

#include <vector>

#include <Eigen/Core>

namespace chasles {

/// A segment of a filter's run, condensed: what its steps did to states that had left the filter
/// before it, and to those that left during it (docs/map.md).
///
/// Its variables are the errors of the state when it began (`starts` rows) and of the states that
/// left during it (`items`). For anything o that left earlier, with the cross-covariance C =
/// cov(o, state at the beginning), the segment gives
///
///   cov(o, state at the end) = C X_starts^T    cov(o, items) = C G_starts,items
///   P_o <- P_o + C G_starts C^T                mean of o <- mean + C g_starts
///
/// where X_starts and so on are columns and blocks. Those of the items are their covariances
/// themselves. A segment without starts is absolute: nothing is older than it.
struct Segment {
  struct Item {
    int number = 0;  ///< of the past state; the numbers of a segment rise
    int size = 0;    ///< rows
  };

  Eigen::Index starts = 0;
  std::vector<Item> items;
  Eigen::MatrixXd X;  ///< rows of the state at the end x variables
  Eigen::MatrixXd G;  ///< variables x variables
  Eigen::VectorXd g;  ///< of the variables: correction of their means
  int length = 1;     ///< number of segments composed into it

  /// First variable of an item, and none if the segment does not have it.
  std::ptrdiff_t place(int number) const;
  std::size_t bytes() const {
    return sizeof(double) * static_cast<std::size_t>(X.size() + G.size() + g.size());
  }
};

/// The variables of those of its items that are in the list. The numbers rise.
std::vector<Eigen::Index> variables_of(const Segment& segment, const std::vector<int>& numbers);

/// The segment that consists of one after the other. The rows of older.X must be younger's starts.
Segment compose(const Segment& older, const Segment& younger);

/// The variables of the starts and of these items alone. The numbers rise.
Segment with_items(const Segment& segment, const std::vector<int>& numbers);

/// Items become rows of the end too, in the order of the list: they have not left after all.
void take_along(Segment& segment, const std::vector<int>& numbers);

/// An item that is a linear function of another one of a segment, plus an error of its own, which
/// is independent of all else.
struct DerivedItem {
  Segment::Item item;
  Eigen::MatrixXd by_source;  ///< rows of the item x rows of the source
  Eigen::MatrixXd own;        ///< covariance of its own error
};

/// The segment with such items too, in the order of their numbers.
Segment with_derived(const Segment& segment, int source, const std::vector<DerivedItem>& derived);

/// Past states as they are at the end of some segment: their covariance, that with the state, and
/// the corrections of their means.
struct Carried {
  std::vector<Segment::Item> items;
  Eigen::MatrixXd C;  ///< rows of the items x rows of the state
  Eigen::MatrixXd P;
  Eigen::VectorXd correction;

  Eigen::Index rows() const { return P.rows(); }
};

/// Carries them through a segment, and adds those of its items that are in the list.
void carry(Carried& past, const Segment& segment, const std::vector<int>& numbers);

}  // namespace chasles
