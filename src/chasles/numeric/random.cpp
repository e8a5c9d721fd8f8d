#include <cmath>
#include <numbers>

#include <chasles/numeric/random.hpp>

namespace chasles {
namespace {

std::uint32_t low(std::uint64_t x) { return static_cast<std::uint32_t>(x); }
std::uint32_t high(std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); }

// The middle of one of 2^52 equal cells: exact in a double, never 0 and never 1.
double open_unit(std::uint32_t a, std::uint32_t b) {
  const std::uint64_t bits = (std::uint64_t{b} << 32 | a) >> 12;
  return (static_cast<double>(bits) + 0.5) * 0x1p-52;
}

std::array<std::uint32_t, 4> draw(std::uint64_t seed, Stream stream, std::uint64_t index,
                                  std::uint32_t component) {
  return philox({low(index), high(index), static_cast<std::uint32_t>(stream), component},
                {low(seed), high(seed)});
}

}  // namespace

std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter,
                                    std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = std::uint64_t{0xD2511F53} * counter[0];
    const std::uint64_t b = std::uint64_t{0xCD9E8D57} * counter[2];
    counter = {high(b) ^ counter[1] ^ key[0], low(b), high(a) ^ counter[3] ^ key[1], low(a)};
    key[0] += 0x9E3779B9;
    key[1] += 0xBB67AE85;
  }
  return counter;
}

double Random::uniform(Stream stream, std::uint64_t index, std::uint32_t component) const {
  const auto bits = draw(seed, stream, index, component);
  return open_unit(bits[0], bits[1]);
}

double Random::normal(Stream stream, std::uint64_t index, std::uint32_t component) const {
  const auto bits = draw(seed, stream, index, component);
  const double radius = std::sqrt(-2 * std::log(open_unit(bits[0], bits[1])));
  return radius * std::cos(2 * std::numbers::pi * open_unit(bits[2], bits[3]));
}

Random random_of_run(std::uint64_t seed, std::uint64_t run) {
  // No Stream has this value, so that the key never coincides with a random number.
  constexpr std::uint32_t kKeyOfRun = 0xffffffff;
  const auto key = philox({low(run), high(run), kKeyOfRun, 0}, {low(seed), high(seed)});
  return {std::uint64_t{key[1]} << 32 | key[0]};
}

}  // namespace chasles
