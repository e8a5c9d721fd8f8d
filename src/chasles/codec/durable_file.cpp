#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/output_file.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

fs::path folder_with(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

[[noreturn]] void reject_replacement(const fs::path& file, int error) {
  throw UsageError(fmt::format("{}: cannot be written: {}", file.string(), std::strerror(error)));
}

void move_over_file(const fs::path& from, const fs::path& file) {
  if (::rename(from.c_str(), file.c_str()) == 0) return;
  const int error = errno;
  std::error_code ignored;
  fs::remove(from, ignored);
  reject_replacement(file, error);
}

bool is_still(const fs::path& path, int descriptor) {
  struct stat opened {
  }, named{};
  return ::fstat(descriptor, &opened) == 0 && ::lstat(path.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

// A file that this process alone has locked, emptied; -1: another one has it, or there are no
// locks.
int locked_file(const fs::path& path, bool& no_locks) {
  for (;;) {
    int flags = O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC;
    int descriptor = ::open(path.c_str(), flags, 0666);
    const bool created = descriptor >= 0;
    if (!created && errno == EEXIST) {
      flags = O_WRONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
      descriptor = ::open(path.c_str(), flags);
      if (descriptor < 0 && errno == ENOENT) continue;  // moved meanwhile
    }
    if (descriptor < 0) reject_replacement(path, errno);
    const bool locked = ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
    no_locks = !locked && errno != EWOULDBLOCK && errno != EINTR;
    if (locked && is_still(path, descriptor) && ::ftruncate(descriptor, 0) == 0) return descriptor;
    if (no_locks && created) ::unlink(path.c_str());
    ::close(descriptor);
    if (!locked) return -1;
  }
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

FolderLock::FolderLock(const fs::path& folder)
    : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  while (descriptor_ >= 0 && ::flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) {
  }
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

PartFile::PartFile(fs::path file) : file_(std::move(file)) {
  bool no_locks = false;
  for (int number = 1; descriptor_ < 0 && !no_locks; ++number) {
    ending_ = number == 1 ? ".part" : fmt::format(".{}.part", number);
    descriptor_ = locked_file(file_.string() + ending_, no_locks);
  }
  if (!no_locks) return;
  ending_ = fmt::format(".of-{}.part", ::getpid());
  descriptor_ = open_to_write(file_.string() + ending_);
}

PartFile::~PartFile() {
  if (descriptor_ < 0) return;
  std::error_code ignored;
  fs::remove(file_.string() + ending_, ignored);
  ::close(descriptor_);
}

void PartFile::write(std::string_view bytes) { write_all(descriptor_, bytes, file_); }

void PartFile::move_over() {
  move_over_file(file_.string() + ending_, file_);
  ::close(std::exchange(descriptor_, -1));
}

void replace_file(const fs::path& file, std::string_view bytes) {
  bool is_left = true;
  replace_file(file, [&](std::string& part) {
    part = bytes;
    return std::exchange(is_left, false);
  });
}

void replace_file(const fs::path& file, const std::function<bool(std::string& part)>& next) {
  std::error_code ignored;
  const bool there = fs::exists(file, ignored);
  if (there && !fs::is_regular_file(file, ignored)) return write_parts(file, next);
  const fs::path target = there ? fs::canonical(file) : followed(file);  // a link stays
  PartFile part(target);
  for (std::string bytes; next(bytes); bytes.clear()) part.write(bytes);
  sync_to_disk(part.path());
  part.move_over();
  sync_to_disk(folder_with(target));
}

FileSet::FileSet(fs::path folder, fs::path mark)
    : folder_(std::move(folder)), mark_(std::move(mark)) {}

FileSet::~FileSet() {
  std::error_code ignored;
  for (const fs::path& name : names_) {
    if (name != mark_) fs::remove(beside(name), ignored);
  }
}

// All files of a set have the ending that the mark's file reserves.
fs::path FileSet::beside(const fs::path& name) const {
  return (folder_ / name).string() + of_mark_->ending();
}

fs::path FileSet::place(const fs::path& name) {
  if (!of_mark_) of_mark_.emplace(folder_ / mark_);
  names_.push_back(name);
  return beside(name);
}

void FileSet::add(const fs::path& name, std::string_view bytes) { write_file(place(name), bytes); }

void FileSet::commit() {
  for (const fs::path& name : names_) sync_to_disk(beside(name));
  const FolderLock lock(folder_);  // against another set: no mix
  remove_file(folder_ / mark_);
  for (const fs::path& name : gone_) remove_file(folder_ / name);
  for (const fs::path& name : names_) {
    if (name != mark_) move_over_file(beside(name), folder_ / name);
  }
  sync_to_disk(folder_);
  of_mark_->move_over();
  sync_to_disk(folder_);
  names_.clear();
}

}  // namespace chasles
