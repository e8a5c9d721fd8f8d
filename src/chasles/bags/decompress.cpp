#include <algorithm>
#include <array>
#include <memory>

#include <fmt/format.h>

#include <chasles/bags/decompress.hpp>
#include <chasles/bags/unpackers.hpp>
#include <chasles/base/error.hpp>

namespace chasles {
namespace {

std::string unpack_all(Unpacker& unpacker, std::string_view packed, std::uint64_t most,
                       const std::string& where) {
  constexpr std::size_t kStep = 1 << 16;
  std::string content;
  std::array<char, kStep> out;
  for (;;) {
    const UnpackStep step = unpacker.step(packed, out.data(), out.size());
    if (step.failure != nullptr) {
      throw InputError(fmt::format("{}: cannot be decompressed: {}", where, step.failure));
    }
    content.append(out.data(), step.made);
    packed.remove_prefix(step.taken);
    if (content.size() > most) {
      throw InputError(fmt::format("{}: decompresses to more than {} bytes, expected at most that",
                                   where, most));
    }
    if (step.ended) return content;
    if (step.taken == 0 && step.made == 0) {
      throw InputError(where + ": cannot be decompressed: it is truncated");
    }
  }
}

}  // namespace

bool is_known_compression(std::string_view compression) {
  constexpr std::array<std::string_view, 5> kKnown{"", "none", "bz2", "lz4", "zstd"};
  return std::find(kKnown.begin(), kKnown.end(), compression) != kKnown.end();
}

std::string decompress(std::string_view packed, std::string_view compression, std::uint64_t most,
                       const std::string& where) {
  if (!is_known_compression(compression)) {
    throw InputError(fmt::format("{}: its compression is '{:.20}', expected none, bz2, lz4 or zstd",
                                 where, compression));
  }
  const std::unique_ptr<Unpacker> unpacker = make_unpacker(compression);
  return unpacker ? unpack_all(*unpacker, packed, most, where) : std::string(packed);
}

}  // namespace chasles
