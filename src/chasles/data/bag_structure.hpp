#pragma once

#include <filesystem>

namespace chasles {

/// Walks through a ROS 1 bag (format 2.0) before librosbag reads it, which follows the lengths and
/// offsets of a damaged one out of its buffers: every record and field lies within the file or its
/// chunk, the index leads to chunks, and its entries to messages of known connections. Inside
/// compressed chunks it cannot look; those carry check sums. Throws InputError with the place.
void check_bag_structure(const std::filesystem::path& file);

}  // namespace chasles
