#include <unistd.h>
#include <utility>

#include <fmt/format.h>

#include <chasles/bags/file_bytes.hpp>
#include <chasles/base/error.hpp>
#include <chasles/base/interruption.hpp>
#include <chasles/codec/read_budget.hpp>

namespace chasles {

std::uint64_t largest_piece() { return read_budget().bytes / 2; }

std::uint64_t most_unpacked(std::uint64_t file_size) {
  constexpr std::uint64_t kMostBagInflation = 200;
  return 2 * read_budget().bytes + kMostBagInflation * file_size;
}

void check_still_there(const std::filesystem::path& file, const std::string& name) {
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored)) return;
  throw InputError(
      name +
      ": cannot be opened again in a forked process, because it is gone or was unpacked "
      "for the first one: start processes with 'spawn', or unpack the bag before");
}

FileBytes::FileBytes(const std::filesystem::path& file, std::string name)
    : file_(file),
      name_(std::move(name)),
      stream_(file, std::ios::binary),
      largest_(largest_piece()) {
  if (!stream_) throw InputError(name_ + ": cannot be opened");
  process_ = getpid();
  stream_.seekg(0, std::ios::end);
  size_ = static_cast<std::uint64_t>(stream_.tellg());
}

std::string FileBytes::read(std::uint64_t at, std::uint64_t count) const {
  interruption_point();
  open_for_this_process();
  if (!holds(at, count)) fail(at, "it is truncated, or a length is wrong");
  if (count > largest_) {
    check_memory(
        fmt::format("{}: a part at byte {} has {} bytes, packed and unpacked", name_, at, count),
        2 * count);
  }
  std::string bytes(count, '\0');
  stream_.clear();
  stream_.seekg(static_cast<std::streamoff>(at));
  stream_.read(bytes.data(), static_cast<std::streamsize>(count));
  if (!stream_) fail(at, "it cannot be read");
  return bytes;
}

// Processes that are forks of one share its place in the file.
void FileBytes::open_for_this_process() const {
  if (process_ == getpid()) return;
  check_still_there(file_, name_);
  stream_ = std::ifstream(file_, std::ios::binary);
  process_ = getpid();
}

void FileBytes::fail(std::uint64_t at, const std::string& what) const {
  throw InputError(
      fmt::format("{}: the bag is damaged: {} at byte {} (a copy that broke off? `rosbag reindex` "
                  "or `mcap recover` may repair it)",
                  name_, what, at));
}

}  // namespace chasles
