#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <deque>
#include <fcntl.h>
#include <fstream>
#include <unistd.h>
#include <vector>

#include <fmt/format.h>
#include <sys/poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <chasles/base/error.hpp>
#include <chasles/many/bounded_processes.hpp>

namespace chasles {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kPollPeriod = 100;  // of the processes in progress [ms]
constexpr int kMostAttempts = 2;

// A process writes messages: the length of its recording, and the result at its end.
enum class Kind : char { kMinutes, kResult };

[[noreturn]] void fail(const std::string& what) {
  throw InputError(what + ": " + std::strerror(errno));
}

void send(int pipe, Kind kind, const void* data, std::size_t size) {
  std::string bytes(1, static_cast<char>(kind));
  bytes.append(reinterpret_cast<const char*>(&size), sizeof size);
  bytes.append(static_cast<const char*>(data), size);
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t n = write(pipe, bytes.data() + at, bytes.size() - at);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) _exit(1);
    at += static_cast<std::size_t>(n);
  }
}

// In the new process: it ends here.
[[noreturn]] void serve(std::size_t item, int pipe, pid_t parent, const BoundedWork& work) {
  // Ctrl-C is for the parent, which decides what becomes of this process.
  signal(SIGINT, SIG_IGN);
  signal(SIGHUP, SIG_IGN);
  signal(SIGTERM, SIG_IGN);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  const std::string result =
      work(item, [&](double minutes) { send(pipe, Kind::kMinutes, &minutes, sizeof minutes); });
  send(pipe, Kind::kResult, result.data(), result.size());
  _exit(0);
}

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

// Processor time of a process so far [s].
double cpu_seconds(pid_t process) {
  std::ifstream file(fmt::format("/proc/{}/stat", process));
  std::string text((std::istreambuf_iterator<char>(file)), {});
  // Its second field is a name that may hold anything, in brackets.
  const std::size_t name_end = text.rfind(')');
  if (name_end == std::string::npos) return 0;
  unsigned long user = 0, system = 0;
  std::sscanf(text.c_str() + name_end + 1, " %*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %lu %lu",
              &user, &system);
  return static_cast<double>(user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

// Memory of a process that is its own, without the files that it has mapped [bytes].
double own_bytes(pid_t process) {
  std::ifstream file(fmt::format("/proc/{}/statm", process));
  double size = 0, resident = 0, shared = 0;
  file >> size >> resident >> shared;
  return (resident - shared) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

class Process {
 public:
  Process(std::size_t item, int attempt, const std::vector<Process>& others,
          const BoundedWork& work)
      : item_(item), attempt_(attempt) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) fail("no pipe for a process");
    const pid_t parent = getpid();
    process_ = fork();
    if (process_ < 0) {
      close(ends[0]);
      close(ends[1]);
      fail("no process for a recording");
    }
    if (process_ == 0) {
      for (const Process& other : others) close(other.in_);
      close(ends[0]);
      serve(item, ends[1], parent, work);
    }
    close(ends[1]);
    in_ = ends[0];
    fcntl(in_, F_SETFL, O_NONBLOCK);
  }

  std::size_t item() const { return item_; }
  int attempt() const { return attempt_; }
  int pipe_end() const { return in_; }

  // Takes what has arrived. Returns false at the end of the pipe.
  bool receive() {
    std::array<char, 65536> chunk;
    for (;;) {
      const ssize_t n = read(in_, chunk.data(), chunk.size());
      if (n > 0) {
        buffer_.append(chunk.data(), static_cast<std::size_t>(n));
        take_messages();
      } else if (n == 0) {
        return false;
      } else if (errno != EINTR) {
        return errno == EAGAIN;
      }
    }
  }

  // Kills it where it is beyond its bounds.
  void hold(const ProcessBounds& bounds) {
    const double minutes = std::max(minutes_, ProcessBounds::kLeastMinutes);
    const double most_seconds = bounds.seconds_per_minute * minutes;
    const double most_megabytes = bounds.megabytes_per_minute * minutes;
    if (how_ != EndedProcess::How::kDone) return;
    if (own_bytes(process_) > 1e6 * most_megabytes) {
      stop(EndedProcess::How::kMemory, fmt::format("needed more than {:.0f} MB", most_megabytes));
    } else if (cpu_seconds(process_) > most_seconds) {
      stop(EndedProcess::How::kTime,
           fmt::format("took more than {:.0f} s of processor time", most_seconds));
    } else if (wall_seconds() > ProcessBounds::kClockFactor * most_seconds) {
      stop(EndedProcess::How::kTime,
           fmt::format("took more than {:.0f} s", ProcessBounds::kClockFactor * most_seconds));
    }
  }

  // Waits for its end, after the pipe's.
  EndedProcess end() {
    int status = 0;
    rusage used{};
    while (wait4(process_, &status, 0, &used) < 0 && errno == EINTR) {
    }
    close(in_);
    EndedProcess ended{.how = how_,
                       .result = std::move(result_),
                       .attempts = attempt_,
                       .wall_seconds = wall_seconds(),
                       .cpu_seconds = seconds_of(used.ru_utime) + seconds_of(used.ru_stime),
                       .peak_bytes = 1024 * static_cast<std::uint64_t>(used.ru_maxrss)};
    if (how_ == EndedProcess::How::kDone && (status != 0 || !has_result_)) {
      ended.how = EndedProcess::How::kDied;
      ended.result = WIFSIGNALED(status)
                         ? fmt::format("the process died by signal {}", WTERMSIG(status))
                         : fmt::format("the process ended with {}", WEXITSTATUS(status));
    }
    return ended;
  }

  void kill_and_wait() {
    kill(process_, SIGKILL);
    end();
  }

 private:
  double wall_seconds() const {
    return std::chrono::duration<double>(Clock::now() - start_).count();
  }

  void stop(EndedProcess::How how, const std::string& why) {
    how_ = how;
    result_ = why;
    kill(process_, SIGKILL);
  }

  void take_messages() {
    std::size_t size = 0;
    constexpr std::size_t kHead = 1 + sizeof size;
    while (buffer_.size() >= kHead) {
      std::memcpy(&size, buffer_.data() + 1, sizeof size);
      if (buffer_.size() < kHead + size) return;
      if (static_cast<Kind>(buffer_[0]) == Kind::kMinutes) {
        std::memcpy(&minutes_, buffer_.data() + kHead, sizeof minutes_);
      } else if (how_ == EndedProcess::How::kDone) {
        result_ = buffer_.substr(kHead, size);
        has_result_ = true;
      }
      buffer_.erase(0, kHead + size);
    }
  }

  std::size_t item_;
  int attempt_;
  pid_t process_ = -1;
  int in_ = -1;
  Clock::time_point start_ = Clock::now();
  double minutes_ = 0;
  EndedProcess::How how_ = EndedProcess::How::kDone;
  bool has_result_ = false;
  std::string result_, buffer_;
};

// The processes in progress. Its destructor kills them.
class Processes {
 public:
  explicit Processes(const BoundedWork& work) : work_(work) {}
  ~Processes() {
    for (Process& process : list_) process.kill_and_wait();
  }
  Processes(const Processes&) = delete;
  Processes& operator=(const Processes&) = delete;

  std::size_t size() const { return list_.size(); }
  void start(std::size_t item, int attempt) {
    list_.push_back(Process(item, attempt, list_, work_));
  }

  // Waits for news of them, and returns one that has ended.
  std::optional<std::pair<Process, EndedProcess>> next_end(const ProcessBounds& bounds) {
    std::vector<pollfd> waiting;
    for (const Process& process : list_) {
      waiting.push_back({.fd = process.pipe_end(), .events = POLLIN, .revents = 0});
    }
    if (poll(waiting.data(), waiting.size(), kPollPeriod) < 0 && errno != EINTR) {
      fail("no news of the processes");
    }
    for (auto process = list_.begin(); process != list_.end(); ++process) {
      if (process->receive()) {
        process->hold(bounds);
        continue;
      }
      Process ended = std::move(*process);
      list_.erase(process);
      const EndedProcess end = ended.end();
      return std::pair{std::move(ended), end};
    }
    return std::nullopt;
  }

 private:
  const BoundedWork& work_;
  std::vector<Process> list_;
};

}  // namespace

bool run_in_bounded_processes(std::span<const std::size_t> items, int jobs,
                              const ProcessBounds& bounds, const BoundedWork& work,
                              const std::function<void(std::size_t, const EndedProcess&)>& done,
                              const std::function<bool()>& stop) {
  struct Due {
    std::size_t item;
    int attempt;
  };
  std::deque<Due> due;
  for (const std::size_t item : items) due.push_back({item, 1});
  Processes processes(work);
  while (!due.empty() || processes.size() > 0) {
    if (stop()) return false;
    while (!due.empty() && processes.size() < static_cast<std::size_t>(std::max(1, jobs))) {
      processes.start(due.front().item, due.front().attempt);
      due.pop_front();
    }
    const auto ended = processes.next_end(bounds);
    if (!ended) continue;
    const auto& [process, end] = *ended;
    if (end.how == EndedProcess::How::kDied && process.attempt() < kMostAttempts) {
      due.push_front({process.item(), process.attempt() + 1});
    } else {
      done(process.item(), end);
    }
  }
  return true;
}

}  // namespace chasles
