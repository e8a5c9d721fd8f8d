#pragma once

#include <functional>
#include <memory>
#include <vector>

#include <chasles/filter/past/passed_segment.hpp>
#include <chasles/filter/past/segment.hpp>

namespace chasles {

/// Successive segments, composed so that there are few. A composition has a bounded number of
/// variables, so memory, and the time of a return, are proportional to the number of items while
/// few of them have returned. Every return adds to each segment that it passes. Where that comes to
/// more than one segment with all items would take, older segments become one.
class SegmentChain {
 public:
  using Keeps = std::function<bool(int number)>;
  /// Starts and rows of items, in a segment that is composed of several.
  static constexpr Eigen::Index kMostVariables = 1000;
  /// With so many rows of items that are kept, at most 16 rows^2 bytes, and these, are left when a
  /// segment is appended.
  static constexpr std::size_t kSpareBytes = 16'000'000;

  explicit SegmentChain(std::size_t spare_bytes = kSpareBytes) : spare_bytes_(spare_bytes) {}

  /// Items for which `keeps` is false are left out where segments are composed.
  void append(Segment segment, const Keeps& keeps);

  /// These items as they are at the end of the last segment. The numbers rise.
  Carried recall(const std::vector<int>& numbers) const;
  /// The same, and they are rows of the state at the end from now on, the last ones, in this order.
  /// As items they are no longer of use.
  Carried revive(const std::vector<int>& numbers);
  /// Adds items that are derived from one of the past.
  void derive(int source, const std::vector<DerivedItem>& derived);

  /// All of them as one, with the items for which `keeps` is true; there must be one.
  Segment composed(const Keeps& keeps) const;
  std::size_t bytes() const;

 private:
  void compose_at(std::size_t older, const Keeps& keeps);
  bool are_few(std::size_t older, const Keeps& keeps) const;
  void begin_with_items(const Keeps& keeps);
  void bound_bytes(const Keeps& keeps);

  std::size_t spare_bytes_;
  std::vector<std::shared_ptr<const PassedSegment>> segments_;  ///< shared with copies of the chain
};

}  // namespace chasles
