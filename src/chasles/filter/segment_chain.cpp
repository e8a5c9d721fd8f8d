#include <algorithm>
#include <utility>

#include <chasles/filter/segment_chain.hpp>

namespace chasles {

// As a binary counter carries: each segment takes part in few compositions.
void SegmentChain::append(Segment segment) {
  segments_.push_back(std::move(segment));
  while (segments_.size() > 1 &&
         segments_[segments_.size() - 2].length <= segments_.back().length) {
    const Segment younger = std::move(segments_.back());
    segments_.pop_back();
    segments_.back() = compose(segments_.back(), younger);
  }
}

Carried SegmentChain::recall(const std::vector<int>& numbers) const {
  Carried past;
  for (const Segment& segment : segments_) carry(past, segment, numbers);
  return past;
}

Carried SegmentChain::revive(const std::vector<int>& numbers) {
  Carried past;
  for (Segment& segment : segments_) {
    const Carried before = past;
    carry(past, segment, numbers);
    if (before.rows() > 0) pass_through(segment, before.C);
    std::vector<int> own;
    for (const Segment::Item& item : segment.items) {
      if (std::ranges::binary_search(numbers, item.number)) own.push_back(item.number);
    }
    take_along(segment, own);
  }
  return past;
}

Segment SegmentChain::composed() const {
  Segment all = segments_.front();
  for (std::size_t i = 1; i < segments_.size(); ++i) all = compose(all, segments_[i]);
  return all;
}

std::size_t SegmentChain::bytes() const {
  std::size_t sum = 0;
  for (const Segment& segment : segments_) sum += segment.bytes();
  return sum;
}

}  // namespace chasles
