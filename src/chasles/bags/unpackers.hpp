#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

namespace chasles {

/// The result of one call of a library: what it took and made, and whether the end is reached.
struct UnpackStep {
  std::size_t taken = 0, made = 0;  ///< [bytes]
  bool ended = false;
  const char* failure = nullptr;  ///< why it cannot go on; null: it can
};

/// Unpacks one stream of compressed bytes piece by piece, in memory that does not grow.
class Unpacker {
 public:
  virtual ~Unpacker() = default;
  /// Takes bytes from the front of `in`, and writes at most `space` bytes to `out`.
  virtual UnpackStep step(std::string_view in, char* out, std::size_t space) = 0;
};

/// An unpacker of "bz2", "lz4" (frames), "zstd" or "gz"; null for another name.
std::unique_ptr<Unpacker> make_unpacker(std::string_view compression);

}  // namespace chasles
