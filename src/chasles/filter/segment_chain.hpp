#pragma once

#include <vector>

#include <chasles/filter/segment.hpp>

namespace chasles {

/// Successive segments, composed so that there are few: a state of the past is recalled in as many
/// steps as the logarithm of their number.
class SegmentChain {
 public:
  void append(Segment segment);

  /// These items as they are at the end of the last segment. The numbers rise.
  Carried recall(const std::vector<int>& numbers) const;
  /// The same, and they are rows of the state at the end from now on, the last ones, in this order.
  Carried revive(const std::vector<int>& numbers);

  /// All of them as one; there must be one.
  Segment composed() const;
  std::size_t bytes() const;

 private:
  std::vector<Segment> segments_;
};

}  // namespace chasles
