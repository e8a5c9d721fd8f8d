#pragma once

#include <cstdint>
#include <string>

namespace chasles::fuzz {

/// A small generator with the same numbers on every platform (splitmix64).
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next();
  /// 0 … n - 1; n > 0.
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(next() % n); }

 private:
  std::uint64_t state_;
};

/// The bytes with one to four damages: bits, bytes, numbers, pieces cut, doubled or moved,
/// containers inside each other, and counts near the number of bytes.
std::string mutate(std::string bytes, Dice& dice);

}  // namespace chasles::fuzz
