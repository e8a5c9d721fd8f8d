#pragma once

#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <spawn.h>
#include <string>
#include <string_view>
#include <unistd.h>
#include <utility>
#include <vector>

#include <sys/wait.h>

#include "cli_test.hpp"

namespace chasles::test {

/// A chasles process, killed by the destructor if it still runs. Its output goes to a file.
class Process {
 public:
  Process(const Scratch& folder, std::vector<std::string> words, const std::string& log = "log")
      : log_((folder / log).string()) {
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 1, log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_adddup2(&actions, 1, 2);
    words.insert(words.begin(), "chasles");
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    posix_spawn(&pid_, CHASLES_BINARY, &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }

  /// The port of the URL that it prints; 0 if it prints none.
  int port() const {
    for (int tries = 0; tries < 5000; ++tries, ::usleep(2000)) {
      const std::string text = slurp(log_);
      const std::size_t at = text.find("http://127.0.0.1:");
      if (at == std::string::npos || text.find('\n', at) == std::string::npos) continue;
      return std::atoi(text.c_str() + at + std::string_view("http://127.0.0.1:").size());
    }
    return 0;
  }
  /// Sends a signal and waits for the end; signal 0 only waits.
  int code_after(int signal) {
    ::kill(pid_, signal);
    int status = 0;
    ::waitpid(std::exchange(pid_, 0), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string output() const { return slurp(log_); }
  /// Whether its output has this text within half a minute.
  bool shows(const std::string& text) const {
    for (int tries = 0; tries < 600; ++tries, ::usleep(50000)) {
      if (output().find(text) != std::string::npos) return true;
    }
    return false;
  }

 private:
  std::string log_;
  pid_t pid_ = 0;
};

}  // namespace chasles::test
