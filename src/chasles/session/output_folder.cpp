#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <fcntl.h>
#include <pthread.h>
#include <unistd.h>

#include <fmt/format.h>
#include <sys/file.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/folder_names.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/session/output_folder.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// Without links, "." and a slash at the end, also of a path that is not there yet.
fs::path resolved(const fs::path& path) {
  std::error_code error;
  fs::path result = fs::weakly_canonical(fs::absolute(path), error);
  if (error) result = fs::absolute(path).lexically_normal();
  return result.has_filename() ? result : result.parent_path();
}

bool is_within(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first ==
         folder.end();
}

// Whether there is nothing, or what an earlier run wrote.
bool is_free(const fs::path& folder) {
  std::error_code ignored;
  return !fs::exists(folder, ignored) || fs::is_empty(folder, ignored) ||
         fs::exists(folder / "summary.json", ignored) || fs::exists(folder / "growing", ignored);
}

// Descriptor + 1 of each lock; 0: free. The locks of a killed process end with it, and not with its
// workers, which close them. A lock beyond these ends with the last worker.
std::array<std::atomic<int>, 16> held_locks{};

void close_in_fork() {
  for (std::atomic<int>& lock : held_locks) {
    if (const int held = lock.exchange(0); held > 0) ::close(held - 1);
  }
}

bool replace_lock(int from, int to) {
  return std::ranges::any_of(held_locks, [&](std::atomic<int>& lock) {
    int expected = from;
    return lock.compare_exchange_strong(expected, to);
  });
}

}  // namespace

std::vector<fs::path> prepare_output(const fs::path& folder) {
  std::vector<fs::path> created;
  std::error_code ignored;
  fs::path part;
  for (const fs::path& name : folder) {
    part /= name;
    if (!fs::exists(part, ignored) && !name.empty()) created.push_back(part);
  }
  make_folder(folder);
  const fs::path probe = folder / ".chasles-probe";
  write_file(probe, "probe");
  remove_file(probe);
  return created;
}

OutputLock::OutputLock(const fs::path& held, bool create)
    : descriptor_(::open(held.c_str(), O_RDONLY | O_CLOEXEC | (create ? O_CREAT : 0), 0666)) {
  if (descriptor_ < 0 || ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) {
    static const int registered = ::pthread_atfork(nullptr, nullptr, close_in_fork);
    listed_ = registered == 0 && descriptor_ >= 0 && replace_lock(0, descriptor_ + 1);
    return;
  }
  ::close(descriptor_);
  throw UsageError(fmt::format(
      "{}: another process is writing into it; wait for its end, or name another folder",
      fs::is_directory(held) ? held.string() : held.parent_path().string()));
}

OutputLock::~OutputLock() {
  // A worker has closed it already.
  if (descriptor_ >= 0 && (!listed_ || replace_lock(descriptor_ + 1, 0))) ::close(descriptor_);
}

void reject_output_into(const fs::path& output, const fs::path& recording) {
  std::error_code ignored;
  if (output.empty() || !fs::exists(recording, ignored)) return;
  const bool is_folder = fs::is_directory(recording, ignored);
  fs::path own = resolved(recording);
  // Truth and plan are beside a mav0 folder, and calibration and truth beside a file.
  if (!is_folder || own.filename() == "mav0") own = own.parent_path();
  const fs::path target = resolved(output);
  if (target != own && (!is_folder || !is_within(target, own) || is_free(target))) return;
  throw UsageError(fmt::format(
      "-o {}: is {} the recording {}, whose files an output may overwrite: choose another folder",
      output.string(), target == own ? "the folder of" : "a folder of", recording.string()));
}

}  // namespace chasles
