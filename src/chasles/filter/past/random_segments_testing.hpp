#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <chasles/filter/past/segment.hpp>
#include <chasles/filter/random_ekf_testing.hpp>

// Segments at random, and one segment that has all items and all their cross-covariances.
namespace chasles::test {

/// With landmarks of successive numbers that leave in it.
inline Segment random_segment(Random& random, Eigen::Index starts, Eigen::Index end, int first,
                              int landmarks) {
  Segment segment;
  segment.starts = starts;
  for (int i = 0; i < landmarks; ++i) segment.items.push_back({.number = first + i, .size = 3});
  const Eigen::Index q = starts + 3 * landmarks;
  // So that nothing grows without bounds.
  segment.X = random_matrix(random, end, q) / std::sqrt(static_cast<double>(q));
  segment.G = random_covariance(random, static_cast<int>(q), 1) / static_cast<double>(q);
  segment.g = random.normal_vector(q);
  return segment;
}

class AllItems {
 public:
  void append(const Segment& segment) { all_ = all_ ? compose(*all_, segment) : segment; }
  Carried recall(const std::vector<int>& numbers) const {
    Carried past;
    carry(past, *all_, numbers);
    return past;
  }
  Carried revive(const std::vector<int>& numbers) {
    Carried past = recall(numbers);
    take_along(*all_, numbers);
    return past;
  }
  /// The numbers rise.
  void keep(const std::vector<int>& numbers) { all_ = with_items(*all_, numbers); }
  Eigen::Index rows() const { return all_ ? all_->X.rows() : 0; }
  const Segment& all() const { return *all_; }

 private:
  std::optional<Segment> all_;
};

/// So many of them at random, rising.
inline std::vector<int> some_of(Random& random, const std::vector<int>& numbers, int count) {
  std::vector<int> chosen;
  for (int i = 0; i < count && !numbers.empty(); ++i) {
    chosen.push_back(numbers[random.next() % numbers.size()]);
  }
  std::ranges::sort(chosen);
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return chosen;
}

}  // namespace chasles::test
