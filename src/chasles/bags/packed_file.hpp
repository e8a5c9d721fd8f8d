#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include <chasles/bags/temporary_file.hpp>

namespace chasles {

// Files that are compressed as a whole: walk_0.mcap.zstd of `ros2 bag record --compression-mode
// file`, walk.bag.gz and their like.

/// The compression of a file by its first bytes: "zstd", "gz", "bz2" or "lz4"; empty for others.
std::string_view packed_as(std::string_view first_bytes);

/// The same for the file; empty if it cannot be read.
std::string_view packed_as_file(const std::filesystem::path& file);

/// walk.mcap for walk.mcap.zstd (.zst, .gz, .bz2, .lz4); other names as they are.
std::filesystem::path unpacked_name(const std::filesystem::path& file);

/// The first `count` bytes of the content of such a file; fewer where it ends or is damaged.
std::string first_unpacked(const std::filesystem::path& file, std::size_t count);

/// Unpacks such a file into a temporary one, in memory that does not grow with it. The streams of
/// parallel and seekable compressors follow each other in a file, and all are read. Throws
/// InputError, starting with the file, if it is damaged or truncated, or if more than
/// most_unpacked() comes out (file_bytes.hpp).
TemporaryFile unpack_file(const std::filesystem::path& file);

}  // namespace chasles
