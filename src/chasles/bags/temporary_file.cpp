#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>

#include <chasles/bags/temporary_file.hpp>
#include <chasles/base/error.hpp>

namespace chasles {
namespace {

// A file without a name, which named() can give one through /proc; -1 where that is not possible.
int open_nameless(const std::filesystem::path& folder) {
#ifdef O_TMPFILE
  if (::access("/proc/self/fd", X_OK) == 0) {
    return ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  }
#endif
  (void)folder;
  return -1;
}

}  // namespace

TemporaryFile::TemporaryFile(std::string where) : where_(std::move(where)) {
  std::error_code error;
  folder_ = std::filesystem::temp_directory_path(error);
  if (error) folder_ = "/tmp";
  file_ = open_nameless(folder_);
  if (file_ >= 0) return;
  std::string name = (folder_ / "chasles-XXXXXX").string();
  file_ = ::mkstemp(name.data());
  if (file_ < 0) fail("made");
  name_ = name;
}

TemporaryFile::TemporaryFile(TemporaryFile&& other) noexcept
    : where_(std::move(other.where_)),
      folder_(std::move(other.folder_)),
      name_(std::exchange(other.name_, {})),
      file_(std::exchange(other.file_, -1)) {}

TemporaryFile::~TemporaryFile() {
  if (file_ >= 0) ::close(file_);
  if (!name_.empty()) ::unlink(name_.c_str());
}

void TemporaryFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail("written");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

const std::filesystem::path& TemporaryFile::named() {
  constexpr int kTries = 1000;
  const std::string self = fmt::format("/proc/self/fd/{}", file_);
  for (int i = 0; name_.empty() && i < kTries; ++i) {
    const std::filesystem::path name = folder_ / fmt::format("chasles-{}-{}", ::getpid(), i);
    if (::linkat(AT_FDCWD, self.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0) {
      name_ = name;
    } else if (errno != EEXIST) {
      break;
    }
  }
  if (name_.empty()) fail("named");
  return name_;
}

void TemporaryFile::fail(const char* what) const {
  throw InputError(
      fmt::format("{}: it needs a temporary file for its content, which cannot be {} in {}: {}; "
                  "set TMPDIR to a folder with space, or unpack it yourself",
                  where_, what, folder_.string(), std::strerror(errno)));
}

}  // namespace chasles
