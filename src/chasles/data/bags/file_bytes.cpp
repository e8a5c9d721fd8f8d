#include <fmt/format.h>

#include <chasles/data/bags/file_bytes.hpp>
#include <chasles/error.hpp>

namespace chasles {

FileBytes::FileBytes(const std::filesystem::path& file)
    : name_(file.string()), stream_(file, std::ios::binary) {
  if (!stream_) throw InputError(name_ + ": cannot be opened");
  stream_.seekg(0, std::ios::end);
  size_ = static_cast<std::uint64_t>(stream_.tellg());
}

std::string FileBytes::read(std::uint64_t at, std::uint64_t count) const {
  if (!holds(at, count)) fail(at, "it is truncated, or a length is wrong");
  if (count > kLargestPiece) {
    fail(at, fmt::format("a part has {} bytes, expected at most {}", count, kLargestPiece));
  }
  std::string bytes(count, '\0');
  stream_.clear();
  stream_.seekg(static_cast<std::streamoff>(at));
  stream_.read(bytes.data(), static_cast<std::streamsize>(count));
  if (!stream_) fail(at, "it cannot be read");
  return bytes;
}

void FileBytes::fail(std::uint64_t at, const std::string& what) const {
  throw InputError(
      fmt::format("{}: the bag is damaged: {} at byte {} (a copy that broke off? `rosbag reindex` "
                  "or `mcap recover` may repair it)",
                  name_, what, at));
}

}  // namespace chasles
