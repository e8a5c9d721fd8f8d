#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include <chasles/data/bag_records.hpp>
#include <chasles/data/bag_structure.hpp>
#include <chasles/error.hpp>

// The format: wiki.ros.org/Bags/Format/2.0.
namespace chasles {
namespace {

constexpr std::string_view kVersion = "#ROSBAG V2.0\n";
constexpr std::uint32_t kLargestChunk = 1u << 28;  // rosbag's own are 768 kB [bytes]

enum Op : std::uint8_t {
  kMessage = 2,
  kBag = 3,
  kIndex = 4,
  kChunk = 5,
  kInfo = 6,
  kConnection = 7
};

// The valid targets of the index.
struct Chunk {
  bool open = false;                 // not compressed
  std::set<std::uint64_t> messages;  // their offsets in the chunk
  std::uint32_t indices = 0;         // number of index records after it
};

class Walk {
 public:
  explicit Walk(const BagBytes& file) : file_(&file) {}

  void check() {
    const BagRecord bag = file_->record(kVersion.size());
    if (bag.op != kBag) file_->fail(bag.at, "there is no bag header");
    const auto encryptor = bag.fields.find("encryptor");
    if (encryptor != bag.fields.end() && !encryptor->second.empty()) {
      file_->fail(bag.at, "is encrypted, expected a plain bag,");
    }
    const auto index = number_in<std::uint64_t>(*file_, bag, "index_pos");
    if (index == 0) file_->fail(bag.at, "there is no index");
    if (index > file_->size()) file_->fail(bag.at, "the index is beyond the end");
    connections(index, number_in<std::uint32_t>(*file_, bag, "conn_count"));
    chunks(bag.data + bag.size, index);
    infos(number_in<std::uint32_t>(*file_, bag, "chunk_count"));
  }

 private:
  void connections(std::uint64_t at, std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; ++i) {
      const BagRecord record = expect(at, kConnection);
      connections_.insert(number_in<std::uint32_t>(*file_, record, "conn"));
      file_->fields(record.data, record.size);
      at = record.data + record.size;
    }
    infos_at_ = at;
  }

  void chunks(std::uint64_t at, std::uint64_t end) {
    Chunk* chunk = nullptr;
    while (at < end) {
      const BagRecord record = file_->record(at);
      if (record.op == kChunk) {
        if (chunk != nullptr) chunk->messages.clear();  // its index is read
        chunk = &(chunks_[at] = read_chunk(record));
      } else if (record.op == kIndex && chunk != nullptr) {
        read_index(record, *chunk);
      } else {
        file_->fail(at, "a record has no place there,");
      }
      at = record.data + record.size;
    }
    if (at != end) file_->fail(at, "a record reaches into the index");
  }

  Chunk read_chunk(const BagRecord& record) const {
    Chunk chunk;
    const auto compression = record.fields.find("compression");
    if (compression == record.fields.end()) file_->fail(record.at, "a chunk has no compression");
    const auto size = number_in<std::uint32_t>(*file_, record, "size");
    if (size > kLargestChunk) file_->fail(record.at, fmt::format("a chunk of {} bytes", size));
    if (compression->second == "bz2" || compression->second == "lz4") return chunk;
    if (compression->second != "none" || size != record.size) {
      file_->fail(record.at, "a chunk's compression or size is wrong");
    }
    chunk.open = true;
    const std::string bytes = file_->bytes(record.data, record.size);
    std::istringstream stream(bytes);
    const BagBytes inside(stream, bytes.size(),
                          fmt::format("{}: the chunk at byte {}", file_->where(), record.data));
    for (std::uint64_t at = 0; at < bytes.size();) {
      const BagRecord one = inside.record(at);
      if (one.op == kMessage) {
        known(record, number_in<std::uint32_t>(inside, one, "conn"));
        chunk.messages.insert(at);
      } else if (one.op == kConnection) {
        inside.fields(one.data, one.size);
      } else {
        inside.fail(at, "a record has no place there,");
      }
      at = one.data + one.size;
    }
    return chunk;
  }

  void read_index(const BagRecord& record, Chunk& chunk) const {
    ++chunk.indices;
    known(record, number_in<std::uint32_t>(*file_, record, "conn"));
    const std::uint64_t count = number_in<std::uint32_t>(*file_, record, "count");
    if (count * 12 != record.size) file_->fail(record.at, "an index is of another size");
    const std::string entries = file_->bytes(record.data, record.size);
    for (std::size_t i = 0; i < entries.size() && chunk.open; i += 12) {
      std::uint32_t offset = 0;
      std::memcpy(&offset, entries.data() + i + 8, sizeof offset);
      if (!chunk.messages.contains(offset)) file_->fail(record.at, "an index leads to no message");
    }
  }

  void infos(std::uint32_t count) {
    std::uint64_t at = infos_at_;
    for (std::uint32_t i = 0; i < count; ++i) {
      const BagRecord record = expect(at, kInfo);
      const auto chunk = chunks_.find(number_in<std::uint64_t>(*file_, record, "chunk_pos"));
      const std::uint64_t indices = number_in<std::uint32_t>(*file_, record, "count");
      if (chunk == chunks_.end()) file_->fail(at, "an index leads to no chunk");
      if (indices * 8 != record.size || indices > chunk->second.indices) {
        file_->fail(at, "an index is of another size");
      }
      at = record.data + record.size;
    }
  }

  BagRecord expect(std::uint64_t at, Op op) const {
    BagRecord record = file_->record(at);
    if (record.op != op) file_->fail(at, "a record of the index is of another kind");
    return record;
  }
  void known(const BagRecord& record, std::uint32_t connection) const {
    if (connections_.contains(connection)) return;
    file_->fail(record.at, fmt::format("connection {} is not known", connection));
  }

  const BagBytes* file_;
  std::set<std::uint32_t> connections_;
  std::map<std::uint64_t, Chunk> chunks_;
  std::uint64_t infos_at_ = 0;
};

}  // namespace

void check_bag_structure(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(file.string() + ": cannot be opened");
  stream.seekg(0, std::ios::end);
  const BagBytes bytes(stream, static_cast<std::uint64_t>(stream.tellg()), file.string());
  const std::string version =
      bytes.bytes(0, std::min<std::uint64_t>(bytes.size(), kVersion.size()));
  if (version != kVersion) {
    throw InputError(fmt::format("{}: is no bag of the format 2.0: rosbag fix converts old ones",
                                 file.string()));
  }
  Walk(bytes).check();
}

}  // namespace chasles
