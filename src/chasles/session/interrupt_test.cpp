#include <csignal>
#include <string>
#include <unistd.h>

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <chasles/session/interrupt.hpp>

namespace chasles {
namespace {

// The exit code of a process that gets so many SIGTERM, and then asks, or does not.
int code_of(unsigned patience, int signals, bool asks) {
  const pid_t process = ::fork();
  if (process == 0) {
    const Interrupt interrupt(patience);
    for (int i = 0; i < signals; ++i) ::raise(SIGTERM);
    for (int i = 0; i < 300; ++i) {
      if (asks && !interrupt.requested()) ::_exit(3);
      ::usleep(10'000);
    }
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(process, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

TEST(Interrupt, TheFirstSignalIsRememberedTheSecondOneEnds) {
  EXPECT_EQ(code_of(0, 1, true), 0);
  EXPECT_EQ(code_of(0, 2, true), -SIGTERM);
}

TEST(Interrupt, WhatIsStuckEnds) {
  EXPECT_EQ(code_of(1, 1, false), Interrupt::kExitCode);
  EXPECT_EQ(code_of(1, 1, true), 0);
}

}  // namespace
}  // namespace chasles
