#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include <sys/types.h>

namespace chasles {

/// Throws InputError if the file of a bag that an earlier process has opened is gone.
void check_still_there(const std::filesystem::path& file, const std::string& name);

/// Random access to the bytes of a file. Reading beyond the end is an InputError; nothing is
/// allocated before the size is compared with that of the file.
class FileBytes {
 public:
  /// `name` is that of messages. Throws InputError if the file cannot be opened.
  FileBytes(const std::filesystem::path& file, std::string name);

  std::uint64_t size() const { return size_; }
  const std::string& name() const { return name_; }
  /// Whether so many bytes are there.
  bool holds(std::uint64_t at, std::uint64_t count) const {
    return at <= size_ && count <= size_ - at;
  }
  /// At most largest_piece() bytes.
  std::string read(std::uint64_t at, std::uint64_t count) const;
  /// Throws InputError: the file, what, and where.
  [[noreturn]] void fail(std::uint64_t at, const std::string& what) const;

 private:
  void open_for_this_process() const;

  std::filesystem::path file_;
  std::string name_;  ///< for messages
  mutable std::ifstream stream_;
  mutable pid_t process_ = 0;  ///< that has opened it
  std::uint64_t size_ = 0, largest_;
};

/// The largest chunk or message of a bag that is read [bytes]: half of the budget
/// (read_budget.hpp), because it may be there packed and unpacked. Recorders make chunks of a
/// megabyte.
std::uint64_t largest_piece();

/// What all chunks or messages of a bag of this size may take, unpacked one after the other: a
/// small file must not fill the day.
std::uint64_t most_unpacked(std::uint64_t file_size);

}  // namespace chasles
