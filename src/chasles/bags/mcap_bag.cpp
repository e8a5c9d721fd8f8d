#include <algorithm>
#include <cstring>
#include <map>
#include <zlib.h>

#include <fmt/format.h>

#include <chasles/bags/chunked_bag.hpp>
#include <chasles/base/error.hpp>

// The format: mcap.dev/spec. Only the data section is read, from its start: the summary at the end
// has nothing that is not there, and files that were not closed have none.
namespace chasles {
namespace {

enum class McapOp : std::uint8_t {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kDataEnd = 15,
};

constexpr std::uint64_t kMcapFrame = 9;     // a record's kind and length
constexpr std::uint64_t kMessageHead = 22;  // of a message record, before the bytes

/// Takes the fields of a record from its front; little-endian.
class McapFields {
 public:
  McapFields(std::string_view bytes, const FileBytes& file, std::uint64_t at)
      : rest_(bytes), file_(&file), at_(at) {}

  std::string_view take(std::uint64_t size) {
    if (size > rest_.size()) file_->fail(at_, "a record is truncated");
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }
  template <typename Number>
  Number number() {
    Number value{};
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  std::string_view text() { return take(number<std::uint32_t>()); }
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  const FileBytes* file_;
  std::uint64_t at_;
};

/// The content of a chunk record.
struct McapChunk {
  std::uint64_t size = 0;
  std::uint32_t check_sum = 0;  // 0: none
  std::string compression = {};
  std::string packed = {};
};

std::uint32_t crc_of(std::string_view bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(
      crc32_z(before, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

Wire wire_of(std::string_view encoding) {
  return encoding == "cdr" ? Wire::kCdr : encoding == "ros1" ? Wire::kRos1 : Wire::kOther;
}

class McapBag : public ChunkedBag {
 public:
  McapBag(const std::filesystem::path& file, const std::string& name) : ChunkedBag(file, name) {
    constexpr std::uint64_t kBegin = 256;  // the first record, the header, is shorter in ours
    const std::uint64_t at = kMcapMagic.size();
    const std::string begin = file_.read(at, std::min(kBegin, file_.size() - at));
    if (begin.size() < kMcapFrame || begin.find("chasles") > kMcapFrame + 8) return;
    McapFields fields(std::string_view(begin).substr(kMcapFrame), file_, at);
    fields.text();
    reject_own_run(fields.text());
  }

  void scan(const Visit& visit, std::vector<std::string>& remarks) override {
    std::uint64_t at = kMcapMagic.size();
    for (;;) {
      if (!file_.holds(at, kMcapFrame)) return not_closed(at, remarks);
      const std::string frame = file_.read(at, kMcapFrame);
      McapFields fields(frame, file_, at);
      const auto op = static_cast<McapOp>(fields.number<std::uint8_t>());
      const auto size = fields.number<std::uint64_t>();
      if (!file_.holds(at + kMcapFrame, size)) return not_closed(at, remarks);
      if (op == McapOp::kDataEnd) return end_of_data(at);
      if (op == McapOp::kFooter) return;
      if (op == McapOp::kChunk) {
        scan_chunk(at, visit);
      } else if (op >= McapOp::kHeader && op <= McapOp::kMessage) {
        const std::string content = file_.read(at + kMcapFrame, size);
        outside_ = outside_ || op == McapOp::kMessage;
        take_record(op, content, {.at = at + kMcapFrame}, visit);
      }
      at += kMcapFrame + size;
    }
  }

 protected:
  std::string unpack_chunk(std::uint64_t at) const override {
    const McapChunk chunk = read_chunk(at);
    std::string content = unpack(chunk.packed, chunk.compression, chunk.size, at);
    if (chunk.check_sum != 0 && chunk.check_sum != crc_of(content)) {
      file_.fail(at, "the check sum of the chunk is wrong");
    }
    return content;
  }

 private:
  void not_closed(std::uint64_t at, std::vector<std::string>& remarks) const {
    if (file_.size() >= 2 * kMcapMagic.size() &&
        file_.read(file_.size() - kMcapMagic.size(), kMcapMagic.size()) == kMcapMagic) {
      file_.fail(at, "the length of a record is wrong");  // the end is there
    }
    remarks.push_back(
        fmt::format("{}: was not closed by its recorder, or is truncated: read up to "
                    "byte {} of {}",
                    file_.name(), at, file_.size()));
  }

  // The check sum of the whole section is needed only where chunks have none of their own.
  void end_of_data(std::uint64_t at) const {
    const std::string content = file_.read(at + kMcapFrame, sizeof(std::uint32_t));
    const auto expected = McapFields(content, file_, at).number<std::uint32_t>();
    if (expected == 0 || !outside_) return;
    constexpr std::uint64_t kPiece = 1 << 20;
    std::uint32_t sum = 0;
    for (std::uint64_t i = 0; i < at; i += kPiece) {
      sum = crc_of(file_.read(i, std::min(kPiece, at - i)), sum);
    }
    if (sum != expected) file_.fail(at, "the check sum of the data is wrong");
  }

  McapChunk read_chunk(std::uint64_t at) const {
    const std::string frame = file_.read(at, kMcapFrame);
    McapFields head(frame, file_, at);
    head.number<std::uint8_t>();
    const std::string content = file_.read(at + kMcapFrame, head.number<std::uint64_t>());
    McapFields fields(content, file_, at);
    fields.take(16);  // times of the first and last message
    McapChunk chunk{.size = fields.number<std::uint64_t>()};
    chunk.check_sum = fields.number<std::uint32_t>();
    chunk.compression = fields.text();
    chunk.packed = fields.take(fields.number<std::uint64_t>());
    return chunk;
  }

  void scan_chunk(std::uint64_t at, const Visit& visit) {
    const std::string content = unpack_chunk(at);
    outside_ = outside_ || read_check_sum(at) == 0;
    McapFields fields(content, file_, at);
    while (!fields.rest().empty()) {
      const auto op = static_cast<McapOp>(fields.number<std::uint8_t>());
      const std::string_view record = fields.take(fields.number<std::uint64_t>());
      const auto begin = static_cast<std::uint64_t>(record.data() - content.data());
      take_record(op, record, {.chunk = at, .at = begin}, visit);
    }
  }

  std::uint32_t read_check_sum(std::uint64_t at) const {
    const std::string bytes = file_.read(at + kMcapFrame + 24, sizeof(std::uint32_t));
    return McapFields(bytes, file_, at).number<std::uint32_t>();
  }

  // `place` is that of the record's content.
  void take_record(McapOp op, std::string_view content, MessagePlace place, const Visit& visit) {
    const std::uint64_t at = place.chunk == MessagePlace::kNoChunk ? place.at : place.chunk;
    McapFields fields(content, file_, at);
    if (op == McapOp::kSchema) {
      const auto number = fields.number<std::uint16_t>();
      schemas_[number] = fields.text();
    } else if (op == McapOp::kChannel) {
      const auto number = fields.number<std::uint16_t>(), schema = fields.number<std::uint16_t>();
      const std::string_view name = fields.text();
      const std::string_view encoding = fields.text();
      BagTopic topic = checked_topic(file_.name(), name, schemas_[schema], wire_of(encoding));
      topic.encoding = encoding.substr(0, 64);
      channels_.insert({number, std::move(topic)});
    } else if (op == McapOp::kMessage) {
      const auto number = fields.number<std::uint16_t>();
      const auto channel = channels_.find(number);
      if (channel == channels_.end()) {
        file_.fail(at, fmt::format("channel {} is not known", number));
      }
      fields.number<std::uint32_t>();
      const auto recorded = static_cast<std::int64_t>(fields.number<std::uint64_t>());
      fields.number<std::uint64_t>();
      place.at += kMessageHead;
      place.size = fields.rest().size();
      visit({.topic = &channel->second,
             .recorded = Time(recorded),
             .place = place,
             .bytes = fields.rest()});
    }
  }

  void reject_own_run(std::string_view library) const {
    if (!library.starts_with("chasles")) return;
    throw InputError(
        fmt::format("{}: is a run that `chasles export` wrote for a viewer (Foxglove, Rerun), "
                    "expected a recording: name the one that was run",
                    file_.name()));
  }

  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, BagTopic> channels_;
  bool outside_ = false;  // a message has no check sum of a chunk
};

}  // namespace

std::unique_ptr<BagFile> open_mcap_bag(const std::filesystem::path& file, const std::string& name) {
  return std::make_unique<McapBag>(file, name);
}

}  // namespace chasles
