#include <cstring>
#include <map>
#include <optional>

#include <fmt/format.h>

#include <chasles/bags/chunked_bag.hpp>
#include <chasles/bags/decompress.hpp>
#include <chasles/base/error.hpp>

// The format: wiki.ros.org/Bags/Format/2.0. The index is not used: the chunks have all that it
// leads to, and a bag that was not closed has none.
namespace chasles {
namespace {

constexpr std::uint32_t kLargestHeader = 1u << 20;  // [bytes]

enum class BagOp : std::uint8_t {
  kMessage = 2,
  kBag = 3,
  kIndex = 4,
  kChunk = 5,
  kInfo = 6,
  kConnection = 7
};

template <typename Number>
Number number_of(std::string_view bytes) {
  Number value{};
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

/// A record: the fields of its header, and where its data is.
struct BagRecord {
  std::string header = {};
  std::uint64_t data = 0;
  std::uint32_t size = 0;
  std::uint64_t end() const { return data + size; }
};

/// The fields "name=value" of a header. A wrong length is an error of the record at `at`.
class BagFields {
 public:
  BagFields(std::string_view header, const FileBytes& file, std::uint64_t at)
      : header_(header), file_(&file), at_(at) {}

  std::optional<std::string_view> find(std::string_view name) const {
    for (std::string_view rest = header_; !rest.empty();) {
      if (rest.size() < 4) fail("a header is truncated");
      const auto length = number_of<std::uint32_t>(rest);
      if (length > rest.size() - 4) fail("a header is truncated");
      const std::string_view field = rest.substr(4, length);
      const std::size_t equal = field.find('=');
      if (equal == std::string_view::npos) fail("a header's field has no value");
      if (field.substr(0, equal) == name) return field.substr(equal + 1);
      rest.remove_prefix(4 + length);
    }
    return std::nullopt;
  }
  template <typename Number>
  Number number(std::string_view name) const {
    const auto value = find(name);
    if (value && value->size() == sizeof(Number)) return number_of<Number>(*value);
    fail(fmt::format("field '{}' is missing or of another size", name));
  }
  std::string_view text(std::string_view name) const {
    if (const auto value = find(name)) return *value;
    fail(fmt::format("field '{}' is missing", name));
  }
  BagOp op() const { return static_cast<BagOp>(number<std::uint8_t>("op")); }

 private:
  [[noreturn]] void fail(const std::string& what) const { file_->fail(at_, what); }

  std::string_view header_;
  const FileBytes* file_;
  std::uint64_t at_;
};

class Ros1Bag : public ChunkedBag {
 public:
  Ros1Bag(const std::filesystem::path& file, const std::string& name) : ChunkedBag(file, name) {
    const std::uint64_t version = kRos1Magic.size();
    if (file_.size() < version || file_.read(0, version) != kRos1Magic) {
      throw InputError(
          file_.name() +
          ": is no bag of the format 2.0: `rosbag fix OLD NEW` converts those of older "
          "formats");
    }
  }

  void scan(const Visit& visit, std::vector<std::string>& remarks) override {
    const bool started = file_.holds(kRos1Magic.size(), 4) &&
                         number_of<std::uint32_t>(file_.read(kRos1Magic.size(), 4)) > 0;
    if (!started) {
      throw InputError(file_.name() +
                       ": ends before its first message: `rosbag record` still runs, or was ended "
                       "by force before it wrote one");
    }
    const BagRecord bag = record(kRos1Magic.size());
    const BagFields fields(bag.header, file_, kRos1Magic.size());
    if (fields.op() != BagOp::kBag) file_.fail(kRos1Magic.size(), "there is no bag header");
    if (!fields.find("encryptor").value_or("").empty()) {
      throw InputError(file_.name() + ": is encrypted, expected a plain bag");
    }
    const auto index = fields.number<std::uint64_t>("index_pos");
    if (index == 0) return scan_open(bag.end(), visit, remarks);
    if (index > file_.size()) file_.fail(kRos1Magic.size(), "the index is beyond the end");
    std::uint64_t at = bag.end();
    while (at < index) at = scan_record(at, visit);
    if (at != index) file_.fail(at, "a record reaches into the index");
    // Without the end of the index the file is not whole either.
    while (at < file_.size()) at = record(at).end();
  }

 protected:
  std::string unpack_chunk(std::uint64_t at) const override {
    const BagRecord chunk = record(at);
    const BagFields fields(chunk.header, file_, at);
    const std::string_view name = fields.text("compression");
    return unpack(file_.read(chunk.data, chunk.size), name, fields.number<std::uint32_t>("size"),
                  at);
  }

 private:
  // The recorder was killed or still runs: the chunks up to the last one are whole.
  void scan_open(std::uint64_t at, const Visit& visit, std::vector<std::string>& remarks) {
    while (file_.holds(at, 8)) {
      const std::uint64_t header = number_of<std::uint32_t>(file_.read(at, 4));
      if (header > kLargestHeader || !file_.holds(at + 4, header + 4)) break;
      const std::uint64_t size = number_of<std::uint32_t>(file_.read(at + 4 + header, 4));
      if (!file_.holds(at + 8 + header, size)) break;
      if (header == 0 || size == 0) break;  // space of the file that was not written
      const BagRecord next = record(at);
      const BagOp op = BagFields(next.header, file_, at).op();
      if (op != BagOp::kChunk && op != BagOp::kIndex) break;
      at = scan_record(at, visit);
    }
    remarks.push_back(
        fmt::format("{}: was not closed by `rosbag record` (.bag.active: it still "
                    "records, or was ended by force): read up to byte {} of {}; `rosbag reindex` "
                    "may recover the rest",
                    file_.name(), at, file_.size()));
  }

  std::uint64_t scan_record(std::uint64_t at, const Visit& visit) {
    const BagRecord next = record(at);
    const BagOp op = BagFields(next.header, file_, at).op();
    if (op == BagOp::kChunk) {
      scan_chunk(at, next, visit);
    } else if (op != BagOp::kIndex) {
      file_.fail(at, "a record has no place there");
    }
    return next.end();
  }

  void scan_chunk(std::uint64_t at, const BagRecord& chunk, const Visit& visit) {
    const std::string content = unpack_chunk(at);
    const std::string_view compression = BagFields(chunk.header, file_, at).text("compression");
    const bool packed = compression != "none";
    for (std::uint64_t i = 0; i < content.size();) {
      const BagRecord one = record_in(content, i, at);
      const BagFields fields(one.header, file_, at);
      const std::string_view data = std::string_view(content).substr(one.data, one.size);
      if (fields.op() == BagOp::kConnection) {
        add_connection(fields, data, at);
      } else if (fields.op() == BagOp::kMessage) {
        const auto connection = fields.number<std::uint32_t>("conn");
        const auto topic = topics_.find(connection);
        if (topic == topics_.end()) {
          file_.fail(at, fmt::format("connection {} is not known", connection));
        }
        const auto time = fields.number<std::uint64_t>("time");
        visit({.topic = &topic->second,
               .recorded =
                   std::chrono::seconds(time & 0xffffffff) + std::chrono::nanoseconds(time >> 32),
               .place = {.chunk = packed ? at : MessagePlace::kNoChunk,
                         .at = packed ? one.data : chunk.data + one.data,
                         .size = one.size},
               .bytes = data});
      } else {
        file_.fail(at, "a record in a chunk has no place there");
      }
      i = one.end();
    }
  }

  void add_connection(const BagFields& fields, std::string_view data, std::uint64_t at) {
    topics_.insert({fields.number<std::uint32_t>("conn"),
                    checked_topic(file_.name(), fields.text("topic"),
                                  BagFields(data, file_, at).text("type"), Wire::kRos1)});
  }

  // A record of the file.
  BagRecord record(std::uint64_t at) const {
    const auto length = number_of<std::uint32_t>(file_.read(at, 4));
    if (length > kLargestHeader) file_.fail(at, "the length of a header is wrong");
    BagRecord record{.header = file_.read(at + 4, length)};
    record.size = number_of<std::uint32_t>(file_.read(at + 4 + length, 4));
    record.data = at + 8 + length;
    if (!file_.holds(record.data, record.size)) file_.fail(at, "a record is truncated");
    return record;
  }

  // A record of the chunk at `chunk`, at byte i of its content.
  BagRecord record_in(std::string_view content, std::uint64_t i, std::uint64_t chunk) const {
    const auto piece = [&](std::uint64_t begin, std::uint64_t size) {
      if (begin > content.size() || size > content.size() - begin) {
        file_.fail(chunk, "a record in a chunk is truncated");
      }
      return content.substr(begin, size);
    };
    const auto length = number_of<std::uint32_t>(piece(i, 4));
    BagRecord record{.header = std::string(piece(i + 4, length))};
    record.size = number_of<std::uint32_t>(piece(i + 4 + length, 4));
    record.data = i + 8 + length;
    piece(record.data, record.size);
    return record;
  }

  std::map<std::uint32_t, BagTopic> topics_;  // by connection
};

}  // namespace

std::unique_ptr<BagFile> open_ros1_bag(const std::filesystem::path& file, const std::string& name) {
  return std::make_unique<Ros1Bag>(file, name);
}

}  // namespace chasles
