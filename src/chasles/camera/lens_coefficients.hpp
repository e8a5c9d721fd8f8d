#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <span>

namespace chasles {

/// The coefficients of a lens model, in the order of its list (lenses/lens_model.hpp). There are
/// only some of them; those that are not stated are 0. No memory is allocated.
class LensCoefficients {
 public:
  static constexpr std::size_t kMost = 12;

  LensCoefficients() = default;
  LensCoefficients(std::initializer_list<double> values)
      : LensCoefficients(std::span(values.begin(), values.size())) {}
  /// The first kMost of the values.
  explicit LensCoefficients(std::span<const double> values)
      : size_(std::min(values.size(), kMost)) {
    std::copy_n(values.begin(), size_, values_.begin());
  }

  std::size_t size() const { return size_; }
  double operator[](std::size_t i) const { return values_[i]; }  ///< i < kMost
  double& operator[](std::size_t i) { return values_[i]; }       ///< i < size()
  const double* begin() const { return values_.data(); }
  const double* end() const { return values_.data() + size_; }

  bool is_zero() const {
    return std::all_of(begin(), end(), [](double value) { return value == 0; });
  }
  bool is_finite() const {
    return std::all_of(begin(), end(), [](double value) { return std::isfinite(value); });
  }
  friend bool operator==(const LensCoefficients&, const LensCoefficients&) = default;

 private:
  std::array<double, kMost> values_{};
  std::size_t size_ = 0;
};

}  // namespace chasles
