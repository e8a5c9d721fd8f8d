#include <csignal>
#include <filesystem>
#include <optional>
#include <unistd.h>

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <chasles/base/error.hpp>
#include <chasles/session/output_folder.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

TEST(OutputLock, SeveralOfOneProcessEndWithItAndNotWithItsWorkers) {
  const fs::path folder = fs::path(testing::TempDir()) / "chasles_output_lock";
  const fs::path first = folder / "first", second = folder / "second";
  fs::create_directories(first);
  fs::create_directories(second);
  std::optional<OutputLock> a(first), b(second);
  EXPECT_THROW(OutputLock{first}, UsageError);
  const pid_t worker = ::fork();
  if (worker == 0) {
    ::pause();
    ::_exit(0);
  }
  a.reset();
  b.reset();
  // The worker closes its copies when it begins.
  const auto is_free = [](const fs::path& held) {
    for (int i = 0; i < 500; ++i) {
      try {
        const OutputLock lock(held);
        return true;
      } catch (const UsageError&) {
        ::usleep(10'000);
      }
    }
    return false;
  };
  EXPECT_TRUE(is_free(first));
  EXPECT_TRUE(is_free(second));
  ::kill(worker, SIGKILL);
  ::waitpid(worker, nullptr, 0);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace chasles
