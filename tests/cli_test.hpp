#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <unistd.h>

#include <gtest/gtest.h>
#include <sys/wait.h>

// Common helpers of the command's tests.
namespace chasles::test {

/// An empty folder for the running test, removed at the end.
class Scratch {
 public:
  Scratch() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::path(::testing::TempDir()) /
            ("chasles_" + std::string(info->test_suite_name()) + "_" + info->name() + "_" +
             std::to_string(::getpid()));
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() { std::filesystem::remove_all(path_); }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  std::string string() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

inline std::string slurp(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream bytes;
  bytes << stream.rdbuf();
  return bytes.str();
}

inline void spill(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

/// Exit code and output of a process.
struct Outcome {
  int code = -1;  ///< -1: ended by a signal
  std::string out, err;
};

/// Runs `chasles ARGUMENTS` in the folder by a shell, after the shell commands `before`.
inline Outcome chasles(const Scratch& folder, const std::string& arguments,
                       const std::string& before = "") {
  const std::string command = "cd '" + folder.string() + "' && " + before + "'" + CHASLES_BINARY +
                              "' " + arguments + " >stdout.txt 2>stderr.txt </dev/null";
  const int status = std::system(command.c_str());
  return {.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1,
          .out = slurp(folder / "stdout.txt"),
          .err = slurp(folder / "stderr.txt")};
}

/// Simulates a stereo-velocity recording of a few seconds into the folder "rec".
inline void simulate(const Scratch& folder, const std::string& more = "") {
  const Outcome made = chasles(folder,
                               "simulate street -o rec --quiet --set route=R "
                               "--set block_length=60 --set block_width=60 " +
                                   more);
  ASSERT_EQ(made.code, 0) << made.err;
}

/// The same with an IMU: a third of a revolution of the turntable.
inline void simulate_turntable(const Scratch& folder) {
  const Outcome made = chasles(folder, "simulate turntable -o rec --quiet --set revolutions=0.3");
  ASSERT_EQ(made.code, 0) << made.err;
}

/// Expects two run folders with the same bytes.
inline void expect_same_runs(const Scratch& folder, const char* one, const char* other) {
  for (const char* file : {"states.csv", "trajectory.tum", "landmarks.csv", "summary.json"}) {
    EXPECT_EQ(slurp(folder / one / file), slurp(folder / other / file)) << file;
  }
}

inline void expect_part(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "no \"" << part << "\" in:\n" << text;
}

/// Expects one error line on stderr and an empty stdout.
inline void expect_error(const Outcome& outcome, int code, const std::string& part) {
  EXPECT_EQ(outcome.code, code) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  const std::size_t at = outcome.err.find("chasles: error: ");
  ASSERT_NE(at, std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.err.find('\n', at), outcome.err.size() - 1) << outcome.err;
  expect_part(outcome.err, part);
}

}  // namespace chasles::test
