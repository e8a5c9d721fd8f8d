#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include <chasles/filter/past/segment.hpp>

namespace chasles {

/// A segment, and what is more at its end because past landmarks have returned since: they are rows
/// of it, those of its own items and those that had left before and only pass. The segment itself
/// stays what it was, so that a return costs as much as the rows of what returns.
///
/// The rows at its start are its starts, and after them the passing ones, which no measurement of
/// the segment concerns. With C = [C_starts, C_passing] of anything o that left earlier, the
/// cross-covariance with one more row of the end is C_starts more_starts^T, plus the column of
/// C_passing if it passes (docs/map.md).
struct PassedSegment {
  std::shared_ptr<const Segment> segment;
  /// Further rows of the end, after those of X: variables x rows, in parts that copies share.
  std::vector<std::shared_ptr<const Eigen::MatrixXd>> more = {};
  std::vector<Eigen::Index> from =
      {};  ///< their places among the passing rows of the start; -1: none

  Eigen::Index more_rows() const { return static_cast<Eigen::Index>(from.size()); }
  Eigen::Index rows() const { return segment->X.rows() + more_rows(); }  ///< of the end
  std::size_t bytes() const {
    return segment->bytes() + sizeof(double) * static_cast<std::size_t>(segment->g.size()) *
                                  static_cast<std::size_t>(more_rows());
  }
};

/// Carries past states through it, and adds those of its items that are in the list.
void carry(Carried& past, const PassedSegment& segment, const std::vector<int>& numbers);

/// The same with those of its items as rows of its end, and those that are carried into it, `past`.
PassedSegment with_returned(const PassedSegment& segment, const Carried& past,
                            const std::vector<int>& numbers);

/// The one that consists of one after the other. Of the rows that only pass the older one, those
/// that returned before the younger one began are starts of it.
PassedSegment compose(const PassedSegment& older, const PassedSegment& younger);

Eigen::Index starts_of_composed(const PassedSegment& older, const PassedSegment& younger);

/// With these items alone. The numbers rise.
PassedSegment with_items(const PassedSegment& segment, const std::vector<int>& numbers);
PassedSegment with_derived(const PassedSegment& segment, int source,
                           const std::vector<DerivedItem>& derived);

/// Where nothing is older than the segment: without starts.
PassedSegment without_starts(const PassedSegment& segment);

/// Where nothing passes: a segment with all rows of its end.
Segment whole(const PassedSegment& segment);

}  // namespace chasles
