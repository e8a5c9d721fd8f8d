#pragma once

#include <filesystem>

namespace chasles {

/// Checks the structure of a ROS 1 bag (format 2.0) before librosbag reads it. librosbag follows
/// the lengths and offsets of a damaged bag out of its buffers. The check covers: every record and
/// field lies within the file or its chunk; the index points to chunks; index entries point to
/// messages of known connections. It does not check inside compressed chunks, which have check
/// sums. Throws InputError with the place.
void check_bag_structure(const std::filesystem::path& file);

}  // namespace chasles
