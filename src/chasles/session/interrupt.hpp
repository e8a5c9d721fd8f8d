#pragma once

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

namespace chasles {

/// During its lifetime the first Ctrl-C (SIGINT) or SIGTERM only sets requested(), so that the run
/// can write its results. The second signal ends the process as usual. A terminal that closes
/// (SIGHUP) sets requested() too, unless the process ignores it (nohup).
class Interrupt {
 public:
  static constexpr int kExitCode = 130;           ///< 128 + SIGINT, the convention of shells
  static constexpr unsigned kPatienceOfRun = 60;  ///< [s]

  /// `patience`: so many seconds after the first signal the process ends with a sentence and this
  /// exit code, if nothing has called requested() since, which is then stuck; 0: it goes on.
  explicit Interrupt(unsigned patience = 0);
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  ~Interrupt();

  bool requested() const;
  void request() const;  ///< same effect as the first signal; any thread

 private:
  struct sigaction before_int_, before_term_, before_hup_, before_alarm_;
};

/// During its lifetime Ctrl-C, SIGTERM and a terminal that closes end the program at once, with a
/// sentence and the exit code of Interrupt: for a command that has written nothing yet. The folders
/// that it has created are removed, unless there is something in them. One at a time.
class EndAtOnce {
 public:
  /// The outermost folder first.
  explicit EndAtOnce(std::vector<std::filesystem::path> folders);
  EndAtOnce(const EndAtOnce&) = delete;
  EndAtOnce& operator=(const EndAtOnce&) = delete;
  ~EndAtOnce();

 private:
  std::vector<std::string> folders_;
  struct sigaction before_int_, before_term_, before_hup_;
};

/// During its lifetime Ctrl-C, SIGTERM and a terminal that closes wait: between what they must find
/// done together.
class SignalsHeld {
 public:
  SignalsHeld();
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;
  ~SignalsHeld();

 private:
  sigset_t before_;
};

}  // namespace chasles
