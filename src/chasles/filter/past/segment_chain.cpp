#include <algorithm>
#include <iterator>
#include <utility>

#include <chasles/filter/past/segment_chain.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Shared = std::shared_ptr<const PassedSegment>;

Index kept_rows(const PassedSegment& segment, const SegmentChain::Keeps& keeps) {
  Index rows = 0;
  for (const Segment::Item& item : segment.segment->items) {
    if (keeps(item.number)) rows += item.size;
  }
  return rows;
}

Shared shortened(const Shared& segment, const SegmentChain::Keeps& keeps) {
  const std::vector<Segment::Item>& items = segment->segment->items;
  std::vector<int> kept;
  for (const Segment::Item& item : items) {
    if (keeps(item.number)) kept.push_back(item.number);
  }
  // A copy of a large segment costs more than a few items in it.
  if (4 * kept.size() >= 3 * items.size()) return segment;
  return std::make_shared<const PassedSegment>(with_items(*segment, kept));
}

}  // namespace

bool SegmentChain::are_few(std::size_t older, const Keeps& keeps) const {
  const PassedSegment &one = *segments_[older], &other = *segments_[older + 1];
  return starts_of_composed(one, other) + kept_rows(one, keeps) + kept_rows(other, keeps) <=
         kMostVariables;
}

void SegmentChain::compose_at(std::size_t older, const Keeps& keeps) {
  const Shared one = shortened(segments_[older], keeps);
  const Shared other = shortened(segments_[older + 1], keeps);
  segments_[older] = std::make_shared<const PassedSegment>(compose(*one, *other));
  segments_.erase(segments_.begin() + static_cast<std::ptrdiff_t>(older) + 1);
}

// Nothing is older than the oldest item.
void SegmentChain::begin_with_items(const Keeps& keeps) {
  while (segments_.size() > 1 && kept_rows(*segments_.front(), keeps) == 0) {
    segments_.erase(segments_.begin());
    segments_.front() = std::make_shared<const PassedSegment>(without_starts(*segments_.front()));
  }
}

// Of those that are composed from the oldest on, none has starts, so all of them together have no
// more variables than items.
void SegmentChain::bound_bytes(const Keeps& keeps) {
  std::size_t rows = 0;
  for (const Shared& segment : segments_) {
    rows += static_cast<std::size_t>(kept_rows(*segment, keeps));
  }
  const std::size_t most = 2 * sizeof(double) * rows * rows + spare_bytes_;
  while (segments_.size() > 1 && bytes() > most) compose_at(0, keeps);
}

// As a binary counter carries: each segment takes part in few compositions. Where items have
// returned, older segments become few enough, too.
void SegmentChain::append(Segment segment, const Keeps& keeps) {
  segments_.push_back(std::make_shared<const PassedSegment>(
      PassedSegment{.segment = std::make_shared<const Segment>(std::move(segment))}));
  begin_with_items(keeps);
  for (std::size_t older = segments_.size() - 1; older-- > 0;) {
    const bool in_order = segments_[older]->segment->length > segments_[older + 1]->segment->length;
    if (!in_order && are_few(older, keeps)) compose_at(older, keeps);
  }
  bound_bytes(keeps);
}

Carried SegmentChain::recall(const std::vector<int>& numbers) const {
  Carried past;
  for (const Shared& segment : segments_) carry(past, *segment, numbers);
  return past;
}

Carried SegmentChain::revive(const std::vector<int>& numbers) {
  Carried past;
  for (Shared& segment : segments_) {
    const Shared before = segment;
    if (past.rows() > 0 || !variables_of(*before->segment, numbers).empty()) {
      segment = std::make_shared<const PassedSegment>(with_returned(*before, past, numbers));
    }
    carry(past, *before, numbers);
  }
  return past;
}

void SegmentChain::derive(int source, const std::vector<DerivedItem>& derived) {
  const auto has_source = [&](const Shared& one) { return one->segment->place(source) >= 0; };
  Shared& segment = *std::ranges::find_if(segments_, has_source);
  segment = std::make_shared<const PassedSegment>(with_derived(*segment, source, derived));
}

Segment SegmentChain::composed(const Keeps& keeps) const {
  Shared all = shortened(segments_.front(), keeps);
  for (auto younger = std::next(segments_.begin()); younger != segments_.end(); ++younger) {
    all = std::make_shared<const PassedSegment>(compose(*all, *shortened(*younger, keeps)));
  }
  return whole(*all);
}

std::size_t SegmentChain::bytes() const {
  std::size_t sum = 0;
  for (const Shared& segment : segments_) sum += segment->bytes();
  return sum;
}

}  // namespace chasles
