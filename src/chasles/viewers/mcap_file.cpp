#include <algorithm>
#include <map>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <zlib.h>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/viewers/byte_sink.hpp>
#include <chasles/viewers/mcap_file.hpp>

namespace chasles {
namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::size_t kChunkBytes = 1 << 20;

// The kinds of records that this file writes.
enum class Op : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0b,
  kSummaryOffset = 0x0e,
  kDataEnd = 0x0f,
};

// The content of a record, field by field.
class Content {
 public:
  template <typename Number>
  Content& add(Number number) {
    append_little_endian(bytes_, number);
    return *this;
  }
  Content& text(std::string_view value) {
    add(static_cast<std::uint32_t>(value.size()));
    bytes_ += value;
    return *this;
  }
  Content& raw(std::string_view value) {
    bytes_ += value;
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

void append_record(std::string& file, Op op, const Content& content) {
  append_little_endian(file, static_cast<std::uint8_t>(op));
  append_little_endian(file, static_cast<std::uint64_t>(content.bytes().size()));
  file += content.bytes();
}

std::uint32_t crc(std::string_view bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()),  //
                                            bytes.size()));
}

std::uint64_t stamp(Time time) { return static_cast<std::uint64_t>(time.count()); }

// The summary's data on a chunk.
struct Chunk {
  std::uint64_t begin = 0, end = 0;  // times
  std::uint64_t offset = 0, length = 0, size = 0, index_length = 0;
  std::map<std::uint16_t, std::uint64_t> index_offsets;
};

// Schemas are numbered from 1: 0 is none.
void append_definitions(std::string& file, const McapFile& content, Op kind) {
  if (kind == Op::kSchema) {
    for (std::size_t i = 0; i < content.schemas.size(); ++i) {
      const McapSchema& s = content.schemas[i];
      append_record(file, kind,
                    Content()
                        .add(static_cast<std::uint16_t>(i + 1))
                        .text(s.name)
                        .text(s.encoding)
                        .text(s.data));
    }
    return;
  }
  for (std::size_t i = 0; i < content.channels.size(); ++i) {
    const McapChannel& c = content.channels[i];
    append_record(file, kind,
                  Content()
                      .add(static_cast<std::uint16_t>(i))
                      .add(static_cast<std::uint16_t>(c.schema + 1))
                      .text(c.topic)
                      .text(c.message_encoding)
                      .text(""));  // metadata: none
  }
}

void check(const McapFile& file) {
  constexpr std::size_t kMost = 65535;
  bool sound = file.schemas.size() < kMost && file.channels.size() < kMost;
  for (const McapChannel& c : file.channels) sound = sound && c.schema < file.schemas.size();
  for (const McapMessage& m : file.messages) sound = sound && m.channel < file.channels.size();
  if (!sound) throw std::invalid_argument("mcap_bytes: a schema or channel that is not there");
  for (const McapMessage& m : file.messages) {
    if (m.time >= Time{}) continue;
    throw InputError(
        fmt::format("a message of {} is at {} ns: an MCAP file has no times before 1970",
                    file.channels[m.channel].topic, m.time.count()));
  }
}

class Writer {
 public:
  explicit Writer(const McapFile& content) : content_(content) {}

  std::string write() {
    file_ = kMagic;
    append_record(file_, Op::kHeader, Content().text("").text(content_.library));
    append_definitions(file_, content_, Op::kSchema);
    append_definitions(file_, content_, Op::kChannel);
    std::vector<std::size_t> order(content_.messages.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return content_.messages[i].time; });
    for (const std::size_t i : order) add(content_.messages[i]);
    close_chunk();
    append_record(file_, Op::kDataEnd, Content().add(crc(file_)));
    append_summary();
    file_ += kMagic;
    return std::move(file_);
  }

 private:
  void add(const McapMessage& m) {
    const auto channel = static_cast<std::uint16_t>(m.channel);
    if (records_.empty()) chunk_.begin = stamp(m.time);
    chunk_.end = stamp(m.time);
    index_[channel].emplace_back(stamp(m.time), records_.size());
    const std::uint64_t sequence = counts_[channel]++;
    append_record(records_, Op::kMessage,
                  Content()
                      .add(channel)
                      .add(static_cast<std::uint32_t>(sequence))
                      .add(stamp(m.time))
                      .add(stamp(m.time))
                      .raw(m.data));
    if (records_.size() >= kChunkBytes) close_chunk();
  }

  void close_chunk() {
    if (records_.empty()) return;
    chunk_.offset = file_.size();
    chunk_.size = records_.size();
    append_record(file_, Op::kChunk,
                  Content()
                      .add(chunk_.begin)
                      .add(chunk_.end)
                      .add(chunk_.size)
                      .add(crc(records_))
                      .text("")  // compression: none
                      .add(chunk_.size)
                      .raw(records_));
    chunk_.length = file_.size() - chunk_.offset;
    for (const auto& [channel, entries] : index_) {
      chunk_.index_offsets[channel] = file_.size();
      Content list;
      for (const auto& [time, offset] : entries) list.add(time).add(offset);
      append_record(file_, Op::kMessageIndex, Content().add(channel).text(list.bytes()));
    }
    chunk_.index_length = file_.size() - chunk_.offset - chunk_.length;
    chunks_.push_back(std::exchange(chunk_, {}));
    records_.clear();
    index_.clear();
  }

  void append_chunk_indices() {
    for (const Chunk& chunk : chunks_) {
      Content offsets;
      for (const auto& [channel, offset] : chunk.index_offsets) offsets.add(channel).add(offset);
      append_record(file_, Op::kChunkIndex,
                    Content()
                        .add(chunk.begin)
                        .add(chunk.end)
                        .add(chunk.offset)
                        .add(chunk.length)
                        .text(offsets.bytes())
                        .add(chunk.index_length)
                        .text("")
                        .add(chunk.size)
                        .add(chunk.size));
    }
  }

  void append_statistics() {
    Content counts;
    for (const auto& [channel, count] : counts_) counts.add(channel).add(count);
    append_record(file_, Op::kStatistics,
                  Content()
                      .add(static_cast<std::uint64_t>(content_.messages.size()))
                      .add(static_cast<std::uint16_t>(content_.schemas.size()))
                      .add(static_cast<std::uint32_t>(content_.channels.size()))
                      .add(std::uint32_t{0})  // attachments
                      .add(std::uint32_t{0})  // metadata
                      .add(static_cast<std::uint32_t>(chunks_.size()))
                      .add(chunks_.empty() ? 0 : chunks_.front().begin)
                      .add(chunks_.empty() ? 0 : chunks_.back().end)
                      .text(counts.bytes()));
  }

  void append_summary() {
    const std::uint64_t start = file_.size();
    std::string offsets;
    const auto group = [&](Op op, const auto& append) {
      const std::uint64_t begin = file_.size();
      append();
      if (file_.size() == begin) return;
      append_record(offsets, Op::kSummaryOffset,
                    Content()
                        .add(static_cast<std::uint8_t>(op))
                        .add(begin)
                        .add(static_cast<std::uint64_t>(file_.size() - begin)));
    };
    group(Op::kSchema, [&] { append_definitions(file_, content_, Op::kSchema); });
    group(Op::kChannel, [&] { append_definitions(file_, content_, Op::kChannel); });
    group(Op::kStatistics, [&] { append_statistics(); });
    group(Op::kChunkIndex, [&] { append_chunk_indices(); });
    const std::uint64_t offset_start = file_.size();
    file_ += offsets;
    // The footer's check sum is of the summary and of the footer up to it.
    append_little_endian(file_, static_cast<std::uint8_t>(Op::kFooter));
    append_little_endian(file_, std::uint64_t{20});
    append_little_endian(file_, start);
    append_little_endian(file_, offset_start);
    append_little_endian(file_, crc(std::string_view(file_).substr(start)));
  }

  const McapFile& content_;
  std::string file_, records_;
  Chunk chunk_;
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> index_;
  std::map<std::uint16_t, std::uint64_t> counts_;
  std::vector<Chunk> chunks_;
};

}  // namespace

std::string mcap_bytes(const McapFile& file) {
  check(file);
  return Writer(file).write();
}

}  // namespace chasles
