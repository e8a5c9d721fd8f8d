#pragma once

#include <cstdlib>
#include <optional>
#include <string>

namespace chasles::test {

/// The folder of temporary files, for a scope.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const char* folder) {
    if (const char* before = std::getenv(kVariable)) before_ = before;
    ::setenv(kVariable, folder, 1);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    if (before_) {
      ::setenv(kVariable, before_->c_str(), 1);
    } else {
      ::unsetenv(kVariable);
    }
  }

 private:
  static constexpr const char* kVariable = "TMPDIR";
  std::optional<std::string> before_;
};

}  // namespace chasles::test
