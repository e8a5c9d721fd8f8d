#include <iterator>
#include <utility>

#include <chasles/filter/copy_on_write.hpp>
#include <chasles/filter/past/segment_chain.hpp>

namespace chasles {
namespace {

void shorten(std::shared_ptr<Segment>& segment, const SegmentChain::Keeps& keeps) {
  std::vector<int> kept;
  for (const Segment::Item& item : segment->items) {
    if (keeps(item.number)) kept.push_back(item.number);
  }
  // A copy of a large segment costs more than a few items in it.
  if (4 * kept.size() >= 3 * segment->items.size()) return;
  segment = std::make_shared<Segment>(with_items(*segment, kept));
}

}  // namespace

// As a binary counter carries: each segment takes part in few compositions.
void SegmentChain::append(Segment segment, const Keeps& keeps) {
  segments_.push_back(std::make_shared<Segment>(std::move(segment)));
  while (segments_.size() > 1 &&
         segments_[segments_.size() - 2]->length <= segments_.back()->length) {
    std::shared_ptr<Segment> younger = std::move(segments_.back());
    segments_.pop_back();
    shorten(younger, keeps);
    shorten(segments_.back(), keeps);
    segments_.back() = std::make_shared<Segment>(compose(*segments_.back(), *younger));
  }
}

Carried SegmentChain::recall(const std::vector<int>& numbers) const {
  Carried past;
  for (const auto& segment : segments_) carry(past, *segment, numbers);
  return past;
}

// Rows that pass through many segments would make all of these larger. So all become one.
Carried SegmentChain::revive(const std::vector<int>& numbers, const Keeps& keeps) {
  if (segments_.size() > 1) {
    Segment all = composed(keeps);
    segments_.clear();
    segments_.push_back(std::make_shared<Segment>(std::move(all)));
  }
  Carried past;
  carry(past, *segments_.front(), numbers);
  take_along(own(segments_.front()), numbers);
  return past;
}

void SegmentChain::derive(int source, const std::vector<DerivedItem>& derived) {
  const auto has_source = [&](const auto& segment) { return segment->place(source) >= 0; };
  std::shared_ptr<Segment>& segment = *std::ranges::find_if(segments_, has_source);
  segment = std::make_shared<Segment>(with_derived(*segment, source, derived));
}

// The younger ones first: the oldest is the largest.
Segment SegmentChain::composed(const Keeps& keeps) const {
  auto all = std::make_shared<Segment>(*segments_.back());
  for (auto older = std::next(segments_.rbegin()); older != segments_.rend(); ++older) {
    *all = compose(**older, *all);
  }
  shorten(all, keeps);
  return std::move(*all);
}

std::size_t SegmentChain::bytes() const {
  std::size_t sum = 0;
  for (const auto& segment : segments_) sum += segment->bytes();
  return sum;
}

}  // namespace chasles
