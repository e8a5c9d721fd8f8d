#pragma once

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <utility>
#include <vector>

/// Private to this folder.
namespace chasles::smooth_detail {

/// Values by their numbers, in rising order: a std::map in one piece of memory, because each frame
/// visits all of them many times. New numbers are mostly the highest. A reference to a value is
/// valid until another number is added or removed.
template <typename T>
class ByNumber {
 public:
  using value_type = std::pair<int, T>;

  auto begin() { return all_.begin(); }
  auto end() { return all_.end(); }
  auto begin() const { return all_.begin(); }
  auto end() const { return all_.end(); }
  std::size_t size() const { return all_.size(); }
  bool empty() const { return all_.empty(); }
  void reserve(std::size_t count) { all_.reserve(count); }

  auto find(int number) { return found(lower(all_, number), number, all_.end()); }
  auto find(int number) const { return found(lower(all_, number), number, all_.end()); }
  bool contains(int number) const { return find(number) != end(); }
  T& at(int number) { return existing(find(number))->second; }
  const T& at(int number) const { return existing(find(number))->second; }

  /// Adds a value unless there is one of this number.
  void emplace(int number, T value) {
    const auto at = !empty() && all_.back().first < number ? all_.end() : lower(all_, number);
    if (at == all_.end() || at->first != number) all_.emplace(at, number, std::move(value));
  }
  void erase(int number) {
    const auto at = find(number);
    if (at != end()) all_.erase(at);
  }
  /// Removes the values of these numbers, which rise.
  void erase(const std::vector<int>& numbers) {
    std::erase_if(all_, [&](const value_type& one) {
      return std::ranges::binary_search(numbers, one.first);
    });
  }

 private:
  template <typename All>
  static auto lower(All& all, int number) {
    return std::ranges::lower_bound(all, number, {}, [](const auto& one) { return one.first; });
  }
  template <typename Iterator>
  static Iterator found(Iterator at, int number, Iterator end) {
    return at != end && at->first == number ? at : end;
  }
  template <typename Iterator>
  Iterator existing(Iterator at) const {
    if (at == end()) throw std::out_of_range("no value has this number");
    return at;
  }

  std::vector<value_type> all_;
};

}  // namespace chasles::smooth_detail
