#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <new>
#include <optional>
#include <unistd.h>
#include <utility>
#include <vector>

#include <sys/mman.h>
#include <sys/poll.h>
#include <sys/wait.h>

#include <chasles/base/error.hpp>
#include <chasles/base/interruption.hpp>
#include <chasles/lab/workers.hpp>

namespace chasles {
namespace {

// The header of a message, followed by `size` bytes.
struct Header {
  std::uint64_t item = 0;
  std::uint64_t size = 0;
  bool failed = false;  // the bytes are an error's message
  bool no_memory = false;
  ExitCode code = ExitCode::kOk;
};

[[noreturn]] void fail(const std::string& what) {
  throw InputError(what + ": " + std::strerror(errno));
}

// The next item to be done, shared by all workers.
class SharedCounter {
 public:
  SharedCounter() {
    void* memory =
        mmap(nullptr, sizeof(Counter), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) fail("no shared memory for the workers");
    counter_ = new (memory) Counter(0);
  }
  ~SharedCounter() { munmap(counter_, sizeof(Counter)); }
  SharedCounter(const SharedCounter&) = delete;
  SharedCounter& operator=(const SharedCounter&) = delete;

  std::size_t next() { return (*counter_)++; }
  void stop() { *counter_ = std::size_t{1} << 62; }

 private:
  using Counter = std::atomic<std::size_t>;
  static_assert(Counter::is_always_lock_free);
  Counter* counter_;
};

bool write_all(int file, const void* data, std::size_t size) {
  const char* from = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t n = write(file, from, size);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    from += n;
    size -= static_cast<std::size_t>(n);
  }
  return true;
}

std::string how_it_ended(int status) {
  if (WIFSIGNALED(status)) return "by signal " + std::to_string(WTERMSIG(status));
  return "with exit status " + std::to_string(WEXITSTATUS(status));
}

// The loop of a worker until no item is left; returns its exit status.
int serve(std::span<const std::uint64_t> items, SharedCounter& counter, int out,
          const std::function<std::string(std::uint64_t)>& work) {
  for (std::size_t i = counter.next(); i < items.size(); i = counter.next()) {
    Header header{.item = items[i]};
    std::string result;
    try {
      result = work(items[i]);
    } catch (const Error& error) {
      header.failed = true;
      header.code = error.code();
      result = error.what();
    } catch (const std::bad_alloc&) {
      header.failed = header.no_memory = true;
    } catch (const std::exception& error) {
      header.failed = true;
      header.code = ExitCode::kBadInput;
      result = error.what();
    }
    header.size = result.size();
    if (!write_all(out, &header, sizeof header) || !write_all(out, result.data(), result.size())) {
      return 1;
    }
    if (header.failed) return 0;
  }
  return 0;
}

struct Worker {
  pid_t process = -1;
  int in = -1;         // this process's end of its pipe; -1: closed
  std::string buffer;  // part of an incomplete message
};

// Receives the messages of the workers as they arrive. Its destructor ends all workers.
class Pool {
 public:
  Pool(std::span<const std::uint64_t> items, int workers,
       const std::function<std::string(std::uint64_t)>& work) {
    for (int i = 0; i < workers; ++i) {
      std::array<int, 2> ends{};
      if (pipe(ends.data()) != 0) {
        if (workers_.empty()) fail("no pipe for a worker");
        return;
      }
      const pid_t process = fork();
      if (process < 0) {
        close(ends[0]);
        close(ends[1]);
        // The workers started so far do all the work.
        if (workers_.empty()) fail("no process for a worker");
        return;
      }
      if (process == 0) {
        for (const Worker& other : workers_) close(other.in);
        close(ends[0]);
        // Without the destructors and buffers of the parent.
        _exit(serve(items, counter_, ends[1], work));
      }
      close(ends[1]);
      workers_.push_back({.process = process, .in = ends[0], .buffer = {}});
    }
  }
  ~Pool() {
    counter_.stop();
    // Whoever interrupts does not wait for the items in progress.
    for (const Worker& worker : workers_) {
      if (interruption_wanted() && worker.process > 0) kill(worker.process, SIGKILL);
    }
    for (Worker& worker : workers_) {
      if (worker.in >= 0) close(worker.in);
      if (worker.process > 0) waitpid(worker.process, nullptr, 0);
    }
  }
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  static constexpr int kBetweenPolls = 100;  // for an interruption [ms]

  template <typename Done>
  void collect(const Done& done) {
    for (;;) {
      std::vector<pollfd> waiting;
      for (const Worker& worker : workers_) {
        if (worker.in >= 0) waiting.push_back({.fd = worker.in, .events = POLLIN, .revents = 0});
      }
      if (waiting.empty()) return;
      interruption_point();
      if (poll(waiting.data(), waiting.size(), kBetweenPolls) < 0) {
        if (errno == EINTR) continue;
        fail("no news of the workers");
      }
      for (const pollfd& one : waiting) {
        if (one.revents != 0) receive(worker_of(one.fd), done);
      }
    }
  }

 private:
  Worker& worker_of(int in) {
    return *std::find_if(workers_.begin(), workers_.end(),
                         [&](const Worker& worker) { return worker.in == in; });
  }

  template <typename Done>
  void receive(Worker& worker, const Done& done) {
    std::array<char, 65536> chunk;
    const ssize_t n = read(worker.in, chunk.data(), chunk.size());
    if (n < 0 && errno == EINTR) return;
    if (n <= 0) {
      close(std::exchange(worker.in, -1));
      int status = 0;
      waitpid(std::exchange(worker.process, -1), &status, 0);
      if (status != 0 || !worker.buffer.empty()) {
        throw InputError("a worker process died " + how_it_ended(status) +
                         ", and its results with it");
      }
      return;
    }
    worker.buffer.append(chunk.data(), static_cast<std::size_t>(n));
    while (auto message = take(worker.buffer)) {
      if (message->first.no_memory) throw std::bad_alloc();
      if (message->first.failed) throw Error(message->first.code, message->second);
      done(message->first.item, message->second);
    }
  }

  static std::optional<std::pair<Header, std::string>> take(std::string& buffer) {
    Header header;
    if (buffer.size() < sizeof header) return std::nullopt;
    std::memcpy(&header, buffer.data(), sizeof header);
    if (buffer.size() < sizeof header + header.size) return std::nullopt;
    std::pair result{header, buffer.substr(sizeof header, header.size)};
    buffer.erase(0, sizeof header + header.size);
    return result;
  }

  SharedCounter counter_;
  std::vector<Worker> workers_;
};

}  // namespace

void work_in_processes(std::span<const std::uint64_t> items, int workers,
                       const std::function<std::string(std::uint64_t)>& work,
                       const std::function<void(std::uint64_t, const std::string&)>& done) {
  if (workers <= 1 || items.size() <= 1) {
    for (const std::uint64_t item : items) done(item, work(item));
    return;
  }
  Pool pool(items, std::min(workers, static_cast<int>(items.size())), work);
  pool.collect(done);
}

}  // namespace chasles
