#include "mutate.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string_view>

namespace chasles::fuzz {
namespace {

/// Strings that are difficult for parsers.
constexpr std::array<std::string_view, 16> kWords = {
    "nan", "inf", "-", "1e999", ",", "\n", "0",     "-1", "99999999999999999999",
    "#",   "\"",  "'", "(",     "{", "\t", "1e-320"};
constexpr std::array<std::uint64_t, 8> kNumbers = {
    0, 1, 0x7f, 0xffff, 0x7fffffff, 0xffffffff, 0x7fffffffffffffff, 0xffffffffffffffff};

/// Beginnings of containers, of JSON, YAML and the header of an .npy array.
constexpr std::array<std::string_view, 6> kOpen = {"[", "{\"a\":", "{a: ", "- ", "[[", "(("};
constexpr std::size_t kMostNested = 4096;

/// A range [first, second) of up to 64 bytes.
std::pair<std::size_t, std::size_t> piece(const std::string& bytes, Dice& dice) {
  const std::size_t begin = dice.below(bytes.size());
  return {begin, std::min(bytes.size(), begin + 1 + dice.below(64))};
}

void overwrite(std::string& bytes, Dice& dice, std::uint64_t number, std::size_t width) {
  if (bytes.size() < width) return;
  std::memcpy(bytes.data() + dice.below(bytes.size() - width + 1), &number, width);
}

/// A container within a container, and so on, or a piece of the bytes many times.
std::string nested(const std::string& piece, Dice& dice) {
  const std::size_t kind = dice.below(kOpen.size() + 1);
  const std::string_view open = kind < kOpen.size() ? kOpen[kind] : std::string_view(piece);
  std::string all;
  for (std::size_t left = 1 + dice.below(kMostNested); left > 0; --left) all += open;
  return all;
}

void damage(std::string& bytes, Dice& dice) {
  if (bytes.empty()) return;
  const std::size_t at = dice.below(bytes.size());
  const auto [begin, end] = piece(bytes, dice);
  switch (dice.below(12)) {
    case 0:
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << dice.below(8)));
      break;
    case 1:
      bytes[at] = static_cast<char>(dice.next());
      break;
    case 2:
      overwrite(bytes, dice, kNumbers[dice.below(kNumbers.size())], 4);
      break;
    case 3:
      overwrite(bytes, dice, kNumbers[dice.below(kNumbers.size())], 8);
      break;
    case 4:
      bytes.erase(begin, end - begin);
      break;
    case 5:
      bytes.insert(at, bytes.substr(begin, end - begin));
      break;
    case 6:
      bytes.insert(at, kWords[dice.below(kWords.size())]);
      break;
    case 7:
      bytes.replace(begin, end - begin, kWords[dice.below(kWords.size())]);
      break;
    case 8:
      bytes.insert(at, nested(bytes.substr(begin, end - begin), dice));
      break;
    case 9:  // a count of as many as there are bytes, or a few times more or less
      overwrite(bytes, dice, bytes.size() << dice.below(20) >> 8, 4);
      break;
    case 10:
      overwrite(bytes, dice, bytes.size() << dice.below(40) >> 8, 8);
      break;
    default:
      bytes.resize(at);
      break;
  }
}

}  // namespace

std::uint64_t Dice::next() {
  state_ += 0x9e3779b97f4a7c15;
  std::uint64_t z = state_;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

std::string mutate(std::string bytes, Dice& dice) {
  for (std::size_t damages = 1 + dice.below(4); damages > 0; --damages) damage(bytes, dice);
  return bytes;
}

}  // namespace chasles::fuzz
