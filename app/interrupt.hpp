#pragma once

#include <csignal>

namespace chasles::app {

/// During its lifetime the first Ctrl-C (SIGINT) or SIGTERM only sets requested(), so that the run
/// can write its results. The second signal ends the process as usual. A terminal that closes
/// (SIGHUP) sets requested() too, unless the process ignores it (nohup).
class Interrupt {
 public:
  static constexpr int kExitCode = 130;  ///< 128 + SIGINT, the convention of shells

  Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  ~Interrupt();

  bool requested() const;
  void request() const;  ///< same effect as the first signal; any thread

 private:
  struct sigaction before_int_, before_term_, before_hup_;
};

}  // namespace chasles::app
