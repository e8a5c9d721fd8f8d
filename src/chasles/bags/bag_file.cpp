#include <algorithm>
#include <array>
#include <fstream>

#include <fmt/format.h>

#include <chasles/bags/bag_file.hpp>
#include <chasles/bags/packed_file.hpp>
#include <chasles/base/error.hpp>
#include <chasles/codec/foreign_files.hpp>

namespace chasles {

std::string ros1_type(std::string_view name) {
  std::string type(name);
  const std::size_t middle = type.find("/msg/");
  return middle == std::string::npos ? type : type.erase(middle, 4);
}

BagTopic checked_topic(const std::string& where, std::string_view name, std::string_view type,
                       Wire wire) {
  constexpr std::size_t kLongestName = 4096;  // [bytes]
  const std::size_t length = std::max(name.size(), type.size());
  if (length <= kLongestName) {
    return {.name = std::string(name), .type = ros1_type(type), .wire = wire};
  }
  throw InputError(
      fmt::format("{}: the name of a topic or its type has {} bytes, expected at most {}: the bag "
                  "is damaged",
                  where, length, kLongestName));
}

namespace {

// `state` of the file is for the message.
std::unique_ptr<BagFile> open_plain(const std::filesystem::path& file, const std::string& name,
                                    const std::string& state) {
  std::array<char, 64> begin{};
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(name + ": cannot be opened");
  stream.read(begin.data(), begin.size());
  const std::string_view bytes(begin.data(), static_cast<std::size_t>(stream.gcount()));
  if (bytes.starts_with("#ROSBAG V")) return open_ros1_bag(file, name);
  if (bytes.starts_with(kMcapMagic)) return open_mcap_bag(file, name);
  if (bytes.starts_with(kSqliteMagic)) return open_sqlite_bag(file, name);
  if (const std::string_view what = stand_in(bytes); !what.empty()) {
    throw InputError(fmt::format("{}:{} is {}", name, state, what));
  }
  throw InputError(fmt::format("{}:{} {}, expected a ROS 1 bag, an MCAP file or a .db3 of ROS 2",
                               name, state,
                               bytes.empty() ? "is empty" : "is no bag by its first bytes"));
}

}  // namespace

bool begins_bag(std::string_view bytes) {
  return bytes.starts_with("#ROSBAG V") || bytes.starts_with(kMcapMagic) ||
         bytes.starts_with(kSqliteMagic);
}

std::unique_ptr<BagFile> open_bag_file(const std::filesystem::path& file) {
  if (const std::string_view packed = packed_as_file(file); !packed.empty()) {
    TemporaryFile content = unpack_file(file);
    return open_plain(content.named(), file.string(),
                      fmt::format(" unpacked ({} as a whole)", packed));
  }
  return open_plain(file, file.string(), "");
}

}  // namespace chasles
