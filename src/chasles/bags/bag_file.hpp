#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <chasles/bags/message_fields.hpp>
#include <chasles/base/time.hpp>

namespace chasles {

/// A topic of a bag and the type of its messages.
struct BagTopic {
  std::string name;
  std::string type;           ///< in the form of ROS 1, "sensor_msgs/Imu", for ROS 2 too
  Wire wire = Wire::kRos1;    ///< the serialisation of the messages
  std::string encoding = {};  ///< its name in the file, "protobuf"; empty in a bag of ROS 1
  bool operator==(const BagTopic&) const = default;
};

/// Where the bytes of a message are: in a chunk, or (kNoChunk) at this offset of the file. Of a
/// database: `at` is the number of the row.
struct MessagePlace {
  static constexpr std::uint64_t kNoChunk = ~std::uint64_t{0};
  std::uint64_t chunk = kNoChunk;  ///< offset of the chunk in the file
  std::uint64_t at = 0;            ///< offset of the first byte
  std::uint64_t size = 0;          ///< [bytes]
};

/// A message as a scan finds it.
struct BagMessage {
  const BagTopic* topic = nullptr;
  Time recorded{};
  MessagePlace place = {};
  std::string_view bytes = {};  ///< valid during the call
};

/// One file of a bag: ROS 1 (format 2.0), a database of ROS 2 (.db3), or an MCAP file. All
/// functions throw InputError with the file and the place.
class BagFile {
 public:
  using Visit = std::function<void(const BagMessage&)>;

  virtual ~BagFile() = default;
  /// Visits all messages in the order of the file. A file that its recorder did not close is read
  /// as far as it goes; `remarks` receives a sentence on that.
  virtual void scan(const Visit& visit, std::vector<std::string>& remarks) = 0;
  /// The bytes of a message that a scan found. Only one thread at a time may call it.
  virtual std::string read(const MessagePlace& place) const = 0;
};

/// Opens a file by its first bytes. One that is compressed as a whole is unpacked into a temporary
/// file first (packed_file.hpp). Throws InputError for one of another kind.
std::unique_ptr<BagFile> open_bag_file(const std::filesystem::path& file);
/// Whether the first bytes are those of such a file.
bool begins_bag(std::string_view bytes);

/// "sensor_msgs/Imu" from "sensor_msgs/msg/Imu".
std::string ros1_type(std::string_view name);

/// A topic as the file `where` names it, the type in either form. Throws InputError for a name of
/// more than 4096 bytes.
BagTopic checked_topic(const std::string& where, std::string_view name, std::string_view type,
                       Wire wire);

// One function for each kind of file; open_bag_file() chooses. `name` is that of messages.
std::unique_ptr<BagFile> open_ros1_bag(const std::filesystem::path& file, const std::string& name);
std::unique_ptr<BagFile> open_mcap_bag(const std::filesystem::path& file, const std::string& name);
std::unique_ptr<BagFile> open_sqlite_bag(const std::filesystem::path& file,
                                         const std::string& name);

inline constexpr std::string_view kRos1Magic = "#ROSBAG V2.0\n";
inline constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);
inline constexpr std::string_view kSqliteMagic("SQLite format 3\0", 16);

}  // namespace chasles
