// Preloaded into the program by tests/crashes.py (LD_PRELOAD). It counts the operations that change
// files below $FAULT_ROOT, and
// - $FAULT_LOG=FILE: writes all of them there, for the simulation of a power cut;
// - $FAULT_KILL=N: kills the process at the N-th, a write in its middle;
// - $FAULT_FULL=N: from the N-th on the disk is full;
// - $FAULT_CLOCK=X: time passes X times as fast, so that a short run writes what a long one does.
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <dlfcn.h>
#include <fcntl.h>
#include <mutex>
#include <string>
#include <unistd.h>

#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>

namespace {

template <typename Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

long number(const char* variable) {
  const char* text = std::getenv(variable);
  return text == nullptr ? 0 : std::atol(text);
}

const std::string& root() {
  static const std::string path = std::getenv("FAULT_ROOT") ? std::getenv("FAULT_ROOT") : "";
  return path;
}

bool inside(const std::string& path) { return !root().empty() && path.starts_with(root()); }

std::string path_of(int descriptor) {
  char path[4096];
  const auto link = "/proc/self/fd/" + std::to_string(descriptor);
  const ssize_t length = ::readlink(link.c_str(), path, sizeof path);
  return length < 0 ? std::string() : std::string(path, static_cast<std::size_t>(length));
}

std::string path_at(int folder, const char* name) {
  return name[0] == '/' || folder == AT_FDCWD ? name : path_of(folder) + "/" + name;
}

void put(int file, const void* data, std::size_t size) { ::syscall(SYS_write, file, data, size); }

void put(int file, const std::string& text) {
  const auto size = static_cast<std::uint32_t>(text.size());
  put(file, &size, sizeof size);
  put(file, text.data(), text.size());
}

void log(char kind, const std::string& path, const std::string& more) {
  static const char* name = std::getenv("FAULT_LOG");
  if (name == nullptr) return;
  static const auto file =
      static_cast<int>(::syscall(SYS_openat, AT_FDCWD, name, O_WRONLY | O_CREAT | O_APPEND, 0644));
  put(file, &kind, 1);
  put(file, path);
  put(file, more);
}

enum class Outcome { kDone, kFull, kKilled };

// What becomes of the operation.
Outcome outcome_of(char kind, const std::string& path, const std::string& more = {}) {
  static std::mutex mutex;
  static long count = 0;
  static const long kill_at = number("FAULT_KILL"), full_at = number("FAULT_FULL");
  if (!inside(path)) return Outcome::kDone;
  const std::lock_guard lock(mutex);
  ++count;
  if (count == kill_at) return Outcome::kKilled;
  const bool allocates = std::strchr("cawms", kind) != nullptr;
  if (full_at > 0 && count >= full_at && allocates) return Outcome::kFull;
  log(kind, path, more);
  return Outcome::kDone;
}

[[noreturn]] void die() {
  ::kill(::getpid(), SIGKILL);
  for (;;) ::pause();
}

// True if the operation fails.
bool fails(char kind, const std::string& path, const std::string& more = {}) {
  const Outcome outcome = outcome_of(kind, path, more);
  if (outcome == Outcome::kKilled) die();
  if (outcome == Outcome::kFull) errno = ENOSPC;
  return outcome == Outcome::kFull;
}

ssize_t written(int descriptor, const std::string& bytes) {
  const Outcome outcome = outcome_of('w', path_of(descriptor), bytes);
  if (outcome == Outcome::kDone)
    return ::syscall(SYS_write, descriptor, bytes.data(), bytes.size());
  const long half = ::syscall(SYS_write, descriptor, bytes.data(), bytes.size() / 2);
  if (outcome == Outcome::kKilled) die();
  if (half > 0) return half;  // the next write fails
  errno = ENOSPC;
  return -1;
}

bool creates(const char* path, int flags) {
  struct stat there {};
  return (flags & O_TRUNC) != 0 || ((flags & O_CREAT) != 0 && ::lstat(path, &there) != 0);
}

int opened_at(int folder, const char* path, int flags, mode_t mode) {
  if (creates(path, flags) && fails('c', path_at(folder, path))) return -1;
  return static_cast<int>(::syscall(SYS_openat, folder, path, flags, mode));
}

using Open = FILE* (*)(const char*, const char*);

FILE* opened(const char* name, const char* path, const char* mode) {
  const char kind = mode[0] == 'w' ? 'c' : 'a';
  if (mode[0] != 'r' && fails(kind, path)) return nullptr;
  return next<Open>(name)(path, mode);
}

}  // namespace

extern "C" {

FILE* fopen(const char* path, const char* mode) { return opened("fopen", path, mode); }
FILE* fopen64(const char* path, const char* mode) { return opened("fopen64", path, mode); }

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  return opened_at(AT_FDCWD, path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  return opened_at(AT_FDCWD, path, flags, mode);
}

ssize_t write(int descriptor, const void* data, size_t size) {
  return written(descriptor, std::string(static_cast<const char*>(data), size));
}

ssize_t writev(int descriptor, const iovec* parts, int count) {
  std::string bytes;
  for (int i = 0; i < count; ++i) {
    bytes.append(static_cast<const char*>(parts[i].iov_base), parts[i].iov_len);
  }
  return written(descriptor, bytes);
}

int fsync(int descriptor) {
  if (fails('s', path_of(descriptor))) return -1;
  return 0;  // quick: the machine's disk is not part of the test
}

int rename(const char* from, const char* to) {
  if (fails('r', from, to)) return -1;
  return next<int (*)(const char*, const char*)>("rename")(from, to);
}

int mkdir(const char* path, mode_t mode) {
  struct stat there {};
  if (::stat(path, &there) != 0 && fails('m', path)) return -1;
  return next<int (*)(const char*, mode_t)>("mkdir")(path, mode);
}

int remove(const char* path) {
  struct stat there {};
  if (::lstat(path, &there) == 0 && fails('u', path)) return -1;
  return next<int (*)(const char*)>("remove")(path);
}

int unlinkat(int folder, const char* name, int flags) {
  if (fails('u', path_at(folder, name))) return -1;
  return next<int (*)(int, const char*, int)>("unlinkat")(folder, name, flags);
}

int clock_gettime(clockid_t clock, timespec* time) {
  static const long factor = number("FAULT_CLOCK");
  const auto result = static_cast<int>(::syscall(SYS_clock_gettime, clock, time));
  if (result != 0 || factor == 0 || clock != CLOCK_MONOTONIC) return result;
  const long nanoseconds = (time->tv_sec % 1'000'000 * 1'000'000'000 + time->tv_nsec) * factor;
  time->tv_sec = nanoseconds / 1'000'000'000;
  time->tv_nsec = nanoseconds % 1'000'000'000;
  return 0;
}

}  // extern "C"
