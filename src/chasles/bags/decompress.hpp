#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace chasles {

/// Whether bytes of this compression can be unpacked: "" and "none", "bz2", "lz4" (frames), "zstd".
bool is_known_compression(std::string_view compression);

/// Unpacks bytes of one of these compressions into at most `most` bytes. The memory grows with what
/// comes out, not with what a file states. Throws InputError, starting with `where`, for damaged or
/// truncated bytes, and for more than `most`.
std::string decompress(std::string_view packed, std::string_view compression, std::uint64_t most,
                       const std::string& where);

}  // namespace chasles
