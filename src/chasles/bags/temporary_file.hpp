#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace chasles {

/// A file in the folder of temporary files ($TMPDIR, else /tmp). Where the system can do that
/// (Linux) it has no name until named(), so that nothing is left of a program that is killed.
class TemporaryFile {
 public:
  /// All functions throw InputError, starting with `where`, if the file cannot be made or written.
  explicit TemporaryFile(std::string where);
  ~TemporaryFile();
  TemporaryFile(TemporaryFile&& other) noexcept;
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  TemporaryFile& operator=(TemporaryFile&&) = delete;

  void write(std::string_view bytes);
  /// Gives the file a name until the destructor takes it away. Who has opened it by then can still
  /// read it; its space is free when all have closed it.
  const std::filesystem::path& named();

 private:
  [[noreturn]] void fail(const char* what) const;

  std::string where_;
  std::filesystem::path folder_, name_;
  int file_ = -1;
};

}  // namespace chasles
