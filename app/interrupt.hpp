#pragma once

#include <csignal>

namespace chasles::app {

/// While it lives, the first Ctrl-C (SIGINT) or SIGTERM only makes requested() true, so that what
/// was estimated so far can be written; the second one ends the process as usual.
class Interrupt {
 public:
  static constexpr int kExitCode = 130;  ///< 128 + SIGINT, as shells have it

  Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  ~Interrupt();

  bool requested() const;
  void request() const;  ///< as the first signal does, from any thread

 private:
  struct sigaction before_int_, before_term_;
};

}  // namespace chasles::app
