#include <atomic>
#include <string_view>
#include <unistd.h>

#include <chasles/session/interrupt.hpp>

namespace chasles {
namespace {

// Access from a signal handler and other threads must be safe.
std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free);

std::atomic<unsigned> seconds_of_patience = 0;

extern "C" void remember_interrupt(int) {
  interrupted = true;
  if (seconds_of_patience > 0) ::alarm(seconds_of_patience);
}

extern "C" void end_stuck(int) {
  constexpr std::string_view kSentence =
      "chasles: error: interrupted, but the program does not get on: nothing more is written\n";
  if (::write(STDERR_FILENO, kSentence.data(), kSentence.size()) < 0) ::_exit(128 + SIGTERM);
  ::_exit(Interrupt::kExitCode);
}

// What EndAtOnce removes.
std::atomic<const std::vector<std::string>*> folders_to_remove = nullptr;

// Calls nothing but what a signal handler may.
extern "C" void end_at_once(int) {
  constexpr std::string_view kSentence = "chasles: error: interrupted: nothing was written\n";
  const auto* folders = folders_to_remove.load();
  for (auto it = folders->rbegin(); it != folders->rend(); ++it) ::rmdir(it->c_str());
  if (::write(STDERR_FILENO, kSentence.data(), kSentence.size()) < 0) ::_exit(128 + SIGINT);
  ::_exit(Interrupt::kExitCode);
}

}  // namespace

Interrupt::Interrupt(unsigned patience) {
  interrupted = false;
  seconds_of_patience = patience;
  struct sigaction action {};
  action.sa_handler = remember_interrupt;
  sigemptyset(&action.sa_mask);
  // A terminal that closes may send it twice, so the second one has no effect. nohup ignores it.
  ::sigaction(SIGHUP, nullptr, &before_hup_);
  if (before_hup_.sa_handler != SIG_IGN) ::sigaction(SIGHUP, &action, nullptr);
  struct sigaction at_alarm = action;
  at_alarm.sa_handler = end_stuck;
  ::sigaction(SIGALRM, patience > 0 ? &at_alarm : nullptr, &before_alarm_);
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // the second signal has its default effect
  ::sigaction(SIGINT, &action, &before_int_);
  ::sigaction(SIGTERM, &action, &before_term_);
}

Interrupt::~Interrupt() {
  if (seconds_of_patience.exchange(0) > 0) ::alarm(0);
  ::sigaction(SIGALRM, &before_alarm_, nullptr);
  ::sigaction(SIGINT, &before_int_, nullptr);
  ::sigaction(SIGTERM, &before_term_, nullptr);
  ::sigaction(SIGHUP, &before_hup_, nullptr);
}

EndAtOnce::EndAtOnce(std::vector<std::filesystem::path> folders) {
  for (const std::filesystem::path& folder : folders) folders_.push_back(folder.string());
  folders_to_remove = &folders_;
  struct sigaction action {};
  action.sa_handler = end_at_once;
  sigemptyset(&action.sa_mask);
  ::sigaction(SIGHUP, nullptr, &before_hup_);
  if (before_hup_.sa_handler != SIG_IGN) ::sigaction(SIGHUP, &action, nullptr);
  ::sigaction(SIGINT, &action, &before_int_);
  ::sigaction(SIGTERM, &action, &before_term_);
}

EndAtOnce::~EndAtOnce() {
  ::sigaction(SIGINT, &before_int_, nullptr);
  ::sigaction(SIGTERM, &before_term_, nullptr);
  ::sigaction(SIGHUP, &before_hup_, nullptr);
}

SignalsHeld::SignalsHeld() {
  sigset_t held;
  sigemptyset(&held);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&held, signal);
  ::pthread_sigmask(SIG_BLOCK, &held, &before_);
}

SignalsHeld::~SignalsHeld() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

bool Interrupt::requested() const {
  if (interrupted && seconds_of_patience > 0) ::alarm(0);  // not stuck
  return interrupted;
}

void Interrupt::request() const { interrupted = true; }

}  // namespace chasles
