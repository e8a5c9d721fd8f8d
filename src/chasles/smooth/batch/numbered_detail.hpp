#pragma once

#include <cstddef>
#include <deque>
#include <utility>

/// Private to this folder.
namespace chasles::smooth_detail {

/// A list whose oldest elements can be removed; the others keep their numbers, which count from 0.
/// A reference to an element is valid until its removal.
template <typename T>
class Numbered {
 public:
  void push_back(T value) { kept_.push_back(std::move(value)); }
  /// Removes the elements with lower numbers.
  void drop_before(int number) {
    for (; first_ < number && !kept_.empty(); ++first_) kept_.pop_front();
  }

  int last() const { return first_ + static_cast<int>(kept_.size()) - 1; }  ///< number
  std::size_t size() const { return kept_.size(); }                         ///< of those kept
  bool empty() const { return kept_.empty(); }

  T& operator[](std::size_t number) { return kept_[number - static_cast<std::size_t>(first_)]; }
  const T& operator[](std::size_t number) const {
    return kept_[number - static_cast<std::size_t>(first_)];
  }
  T& front() { return kept_.front(); }
  T& back() { return kept_.back(); }
  const T& back() const { return kept_.back(); }
  auto begin() { return kept_.begin(); }
  auto end() { return kept_.end(); }
  auto begin() const { return kept_.begin(); }
  auto end() const { return kept_.end(); }

 private:
  std::deque<T> kept_;
  int first_ = 0;
};

}  // namespace chasles::smooth_detail
