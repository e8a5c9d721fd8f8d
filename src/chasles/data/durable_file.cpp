#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>

#include <chasles/data/durable_file.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

fs::path beside(const fs::path& file) { return file.string() + ".part"; }

// Writes FILE.part; where that fails, it is removed again.
void write_beside(const fs::path& file, std::string_view bytes) {
  try {
    write_file(beside(file), bytes);
    sync_to_disk(beside(file));
  } catch (const UsageError&) {
    std::error_code ignored;
    fs::remove(beside(file), ignored);
    throw;
  }
}

void move_over(const fs::path& file) {
  std::error_code error;
  fs::rename(beside(file), file, error);
  if (!error) return;
  std::error_code ignored;
  fs::remove(beside(file), ignored);
  throw UsageError(fmt::format("{}: cannot be written: {}", file.string(), error.message()));
}

}  // namespace

void sync_to_disk(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = descriptor >= 0 && (::fsync(descriptor) == 0 || errno == EINVAL);
  const int error = errno;  // EINVAL: a file system that has no fsync
  if (descriptor >= 0) ::close(descriptor);
  if (synced) return;
  throw UsageError(
      fmt::format("{}: cannot be written to the disk: {}", path.string(), std::strerror(error)));
}

void replace_file(const fs::path& file, std::string_view bytes) {
  std::error_code ignored;
  const bool there = fs::exists(file, ignored);
  if (there && !fs::is_regular_file(file, ignored)) return write_file(file, bytes);
  const fs::path target = there ? fs::canonical(file) : file;  // a link stays
  write_beside(target, bytes);
  move_over(target);
  sync_to_disk(target.has_parent_path() ? target.parent_path() : ".");
}

FileSet::FileSet(fs::path folder, fs::path mark)
    : folder_(std::move(folder)), mark_(std::move(mark)) {}

FileSet::~FileSet() {
  std::error_code ignored;
  for (const fs::path& name : names_) fs::remove(beside(folder_ / name), ignored);
}

fs::path FileSet::place(const fs::path& name) {
  names_.push_back(name);
  return beside(folder_ / name);
}

void FileSet::add(const fs::path& name, std::string_view bytes) { write_file(place(name), bytes); }

void FileSet::commit() {
  for (const fs::path& name : names_) sync_to_disk(beside(folder_ / name));
  remove_file(folder_ / mark_);
  for (const fs::path& name : gone_) remove_file(folder_ / name);
  for (const fs::path& name : names_) {
    if (name != mark_) move_over(folder_ / name);
  }
  sync_to_disk(folder_);
  move_over(folder_ / mark_);
  sync_to_disk(folder_);
  names_.clear();
}

}  // namespace chasles
