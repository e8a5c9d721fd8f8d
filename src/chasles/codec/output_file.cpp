#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <unistd.h>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/output_file.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void reject_output(const fs::path& file, int error) {
  if (error == ENXIO) {
    throw UsageError(fmt::format(
        "{}: cannot be written: it is a socket, or a pipe that no program reads; expected a file, "
        "or a pipe whose reader runs already",
        file.string()));
  }
  throw UsageError(fmt::format("{}: cannot be written: {}", file.string(), std::strerror(error)));
}

}  // namespace

int open_to_write(const fs::path& file) {
  constexpr int kFlags = O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NONBLOCK;
  const int descriptor = ::open(file.c_str(), kFlags, 0666);
  if (descriptor < 0) reject_output(file, errno);
  const int flags = ::fcntl(descriptor, F_GETFL);
  if (flags >= 0) ::fcntl(descriptor, F_SETFL, flags & ~O_NONBLOCK);
  return descriptor;
}

void write_all(int descriptor, std::string_view bytes, const fs::path& file) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) reject_output(file, written < 0 ? errno : ENOSPC);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

fs::path followed(const fs::path& file) {
  constexpr int kMostLinks = 40;  // as Linux
  fs::path at = file;
  std::error_code error;
  for (int links = 0; fs::is_symlink(fs::symlink_status(at, error)); ++links) {
    if (links == kMostLinks) {
      throw UsageError(file.string() +
                       ": is a link that leads back to itself, expected a file or a link to one");
    }
    const fs::path target = fs::read_symlink(at, error);
    if (error) reject_output(file, error.value());
    at = target.is_absolute() ? target : at.parent_path() / target;
  }
  const fs::path folder = at.has_parent_path() ? at.parent_path() : ".";
  if (at == file || fs::is_directory(folder, error)) return at;
  throw UsageError(fmt::format("{}: is a link to {}, and there is no folder {}", file.string(),
                               at.string(), folder.string()));
}

void reject_pipe(const fs::path& file) {
  std::error_code ignored;
  const fs::path target = fs::weakly_canonical(file, ignored);
  const fs::file_status status = fs::status(file, ignored);
  const bool of_process = target.string().starts_with("/proc/");
  if (of_process || (!fs::is_fifo(status) && !fs::is_socket(status))) return;
  throw UsageError(fmt::format("{}: is a {}, expected the name of a file", file.string(),
                               fs::is_fifo(status) ? "pipe" : "socket"));
}

}  // namespace chasles
