#include <algorithm>
#include <cstdint>
#include <map>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>
#include <sqlite3.h>

#include <chasles/bags/bag_file.hpp>
#include <chasles/bags/file_bytes.hpp>
#include <chasles/base/error.hpp>
#include <chasles/base/interruption.hpp>

// A database of rosbag2_storage_sqlite3: tables `topics` (id, name, type, serialization_format) and
// `messages` (topic_id, timestamp, data).
namespace chasles {
namespace {

constexpr std::uint64_t kSqliteMost = 0x7fffffff;  // SQLite's own limit is below

using Database = std::unique_ptr<sqlite3, decltype(&sqlite3_close)>;
using Statement = std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)>;

// Only plain reading: a view or a generated column of a made-up database could compute for ever.
int only_reading(void*, int action, const char*, const char*, const char*, const char*) {
  return action == SQLITE_SELECT || action == SQLITE_READ ? SQLITE_OK : SQLITE_DENY;
}

// A database without a journal is opened as one that nobody writes to: it then needs no files
// beside it, which may be in a folder without the right to make them.
std::string uri_of(const std::filesystem::path& file) {
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(file).string()) {
    uri += c == '?' || c == '#' || c == '%' ? fmt::format("%{:02x}", c) : std::string(1, c);
  }
  std::error_code ignored;
  const bool journal = std::filesystem::exists(file.string() + "-wal", ignored);
  return uri + (journal ? "" : "?immutable=1");
}

std::string text_of(sqlite3_stmt* row, int column) {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(row, column));
  return text == nullptr
             ? std::string()
             : std::string(text, static_cast<std::size_t>(sqlite3_column_bytes(row, column)));
}

std::string_view blob_of(sqlite3_stmt* row, int column) {
  const auto* bytes = static_cast<const char*>(sqlite3_column_blob(row, column));
  return bytes == nullptr
             ? std::string_view()
             : std::string_view(bytes, static_cast<std::size_t>(sqlite3_column_bytes(row, column)));
}

// The bytes of the database, with those that its journal has.
std::uint64_t bytes_of(const std::filesystem::path& file) {
  std::error_code ignored;
  const std::filesystem::path journal = file.string() + "-wal";
  return std::filesystem::file_size(file) +
         (std::filesystem::exists(journal, ignored) ? std::filesystem::file_size(journal) : 0);
}

class SqliteBag : public BagFile {
 public:
  SqliteBag(const std::filesystem::path& file, std::string name)
      : file_(file),
        name_(std::move(name)),
        bytes_(bytes_of(file)),
        database_(nullptr, &sqlite3_close) {
    open();
  }

  void open() const {
    sqlite3* opened = nullptr;
    process_ = getpid();
    const int result = sqlite3_open_v2(uri_of(file_).c_str(), &opened,
                                       SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
    database_.reset(opened);
    if (result != SQLITE_OK) fail();
    sqlite3_limit(opened, SQLITE_LIMIT_LENGTH,
                  static_cast<int>(std::min(largest_piece(), kSqliteMost)));
    sqlite3_set_authorizer(opened, &only_reading, nullptr);
    sqlite3_progress_handler(opened, kStepsOfCall, &count_steps, const_cast<SqliteBag*>(this));
  }

  void scan(const Visit& visit, std::vector<std::string>&) override {
    for (const char* table : {"topics", "messages"}) check_table(table);
    read_topics();
    std::uint64_t read = 0;
    const Statement rows = prepare("SELECT rowid, topic_id, timestamp, data FROM messages");
    while (step(rows)) {
      const auto topic = topics_.find(sqlite3_column_int64(rows.get(), 1));
      if (topic == topics_.end()) continue;
      const sqlite3_int64 row = sqlite3_column_int64(rows.get(), 0);
      const Time recorded(sqlite3_column_int64(rows.get(), 2));
      const std::string_view data = blob_of(rows.get(), 3);
      read += data.size();
      if (read > bytes_) fail_with("its messages have more bytes than the file");
      visit({.topic = &topic->second,
             .recorded = recorded,
             .place = {.at = static_cast<std::uint64_t>(row), .size = data.size()},
             .bytes = data});
    }
  }

  std::string read(const MessagePlace& place) const override {
    if (process_ != getpid()) {  // a fork shares the place in the file
      check_still_there(file_, name_);
      open();
    }
    const Statement row = prepare("SELECT data FROM messages WHERE rowid = ?");
    sqlite3_bind_int64(row.get(), 1, static_cast<sqlite3_int64>(place.at));
    if (step(row)) return std::string(blob_of(row.get(), 0));
    throw InputError(
        fmt::format("{}: message {} is no longer there: was the bag changed?", name_, place.at));
  }

 private:
  static constexpr int kStepsOfCall = 1000;
  static constexpr std::uint64_t kStepsOfByte = 10, kLeastSteps = 1'000'000;

  // A row takes about ten steps and as many bytes: a scan is over before, unless the database is
  // made to compute for ever.
  static int count_steps(void* self) {
    auto& bag = *static_cast<SqliteBag*>(self);
    bag.steps_ += kStepsOfCall;
    const bool too_many = bag.steps_ > kLeastSteps + kStepsOfByte * bag.bytes_;
    return too_many || interruption_wanted() ? 1 : 0;
  }

  // A view would be read as a table is, and may compute anything.
  void check_table(const char* name) const {
    const Statement rows = prepare("SELECT type FROM sqlite_master WHERE name = ? COLLATE NOCASE");
    sqlite3_bind_text(rows.get(), 1, name, -1, SQLITE_STATIC);
    if (!step(rows)) fail_with(fmt::format("there is no table '{}'", name));
    if (text_of(rows.get(), 0) != "table") fail_with(fmt::format("'{}' is no table", name));
  }

  void read_topics() {
    const Statement rows = prepare("SELECT id, name, type, serialization_format FROM topics");
    while (step(rows)) {
      const std::string encoding = text_of(rows.get(), 3);
      BagTopic topic = checked_topic(name_, text_of(rows.get(), 1), text_of(rows.get(), 2),
                                     encoding == "cdr" ? Wire::kCdr : Wire::kOther);
      topic.encoding = encoding.substr(0, 64);
      topics_.insert({sqlite3_column_int64(rows.get(), 0), std::move(topic)});
    }
  }

  Statement prepare(const char* query) const {
    sqlite3_stmt* statement = nullptr;
    if (sqlite3_prepare_v2(database_.get(), query, -1, &statement, nullptr) != SQLITE_OK) fail();
    return {statement, &sqlite3_finalize};
  }
  // Whether there is a row.
  bool step(const Statement& statement) const {
    const int result = sqlite3_step(statement.get());
    if (result == SQLITE_ROW) return true;
    if (result == SQLITE_DONE) return false;
    fail();
  }
  [[noreturn]] void fail() const {
    if (!database_) fail_with("cannot be opened");
    if (sqlite3_errcode(database_.get()) == SQLITE_INTERRUPT) {
      fail_with(fmt::format("reading takes more than {} steps", steps_));
    }
    fail_with(sqlite3_errmsg(database_.get()));
  }
  [[noreturn]] void fail_with(const std::string& what) const {
    throw InputError(fmt::format(
        "{}: {}: the database is damaged, or is no bag of ROS 2 (a copy that broke off?)", name_,
        what));
  }

  std::filesystem::path file_;
  std::string name_;  ///< for messages
  std::uint64_t bytes_, steps_ = 0;
  mutable Database database_;
  mutable pid_t process_ = 0;  // that has opened it
  std::map<sqlite3_int64, BagTopic> topics_;
};

}  // namespace

std::unique_ptr<BagFile> open_sqlite_bag(const std::filesystem::path& file,
                                         const std::string& name) {
  return std::make_unique<SqliteBag>(file, name);
}

}  // namespace chasles
