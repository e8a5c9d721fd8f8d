#include <csignal>
#include <filesystem>
#include <new>
#include <system_error>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/session/fault.hpp>

namespace chasles {
namespace {

constexpr int kLacking = 70;  // an internal error, or the system lacks something: sysexits.h
constexpr int kUnusable = static_cast<int>(ExitCode::kUsage);

Fault fault_of_files(const std::filesystem::filesystem_error& error) {
  const std::string reason = error.code().message();
  if (error.path1().empty()) return {"the working folder cannot be found: " + reason, kUnusable};
  return {fmt::format("{}: cannot be used: {}", error.path1().string(), reason), kUnusable};
}

Fault fault_of_system(const std::system_error& error) {
  const std::error_code code = error.code();
  if (code == std::errc::not_enough_memory) return {"out of memory", kLacking};
  if (code == std::errc::resource_unavailable_try_again) {
    return {
        "out of threads: the limit of processes (ulimit -u), of memory (ulimit -v) or of the "
        "container is reached; raise it, or use --threads 1",
        kLacking};
  }
  if (code == std::errc::too_many_files_open || code == std::errc::too_many_files_open_in_system) {
    return {"too many open files: raise the limit (ulimit -n)", kLacking};
  }
  return {fmt::format("internal error, please report it: {}", error.what()), kLacking};
}

Fault described(const std::exception& error) {
  if (const auto* known = dynamic_cast<const Error*>(&error)) {
    return {known->what(), static_cast<int>(known->code())};
  }
  if (dynamic_cast<const std::bad_alloc*>(&error)) return {"out of memory", kLacking};
  if (const auto* of_file = dynamic_cast<const std::filesystem::filesystem_error*>(&error)) {
    return fault_of_files(*of_file);
  }
  if (const auto* of_os = dynamic_cast<const std::system_error*>(&error)) {
    return fault_of_system(*of_os);
  }
  return {fmt::format("internal error, please report it: {}", error.what()), kLacking};
}

bool is_working_folder_there() {
  std::error_code error;
  static_cast<void>(std::filesystem::current_path(error));
  return error != std::errc::no_such_file_or_directory;
}

}  // namespace

Fault fault_of(const std::exception& error) {
  Fault fault = described(error);
  if (fault.code != kLacking && !is_working_folder_there()) {
    fault.sentence += "; the working folder was removed: change to another folder";
  }
  return fault;
}

void report_file_limit() { std::signal(SIGXFSZ, SIG_IGN); }

}  // namespace chasles
