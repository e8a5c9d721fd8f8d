#include "ranks.hpp"

#ifdef CHASLES_HAS_MPI

#include <cstdlib>
#include <cstring>
#include <deque>
#include <limits>
#include <utility>

#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>

#include <spdlog/spdlog.h>

#include <chasles/base/error.hpp>

namespace chasles::app {
namespace {

constexpr int kTag = 1;
constexpr std::uint64_t kFailed = std::numeric_limits<std::uint64_t>::max();

// MPI_Init without mpirun searches for a cluster, which takes longer than most commands.
bool started_by_mpirun() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"}) {
    if (std::getenv(name)) return true;
  }
  return false;
}

// A message: the item or kFailed, then the bytes.
std::string message_of(std::uint64_t item, const std::string& bytes) {
  std::string message(sizeof item, '\0');
  std::memcpy(message.data(), &item, sizeof item);
  return message + bytes;
}

[[noreturn]] void abort_job(const std::string& message, ExitCode code) {
  spdlog::error("{}", message);
  MPI_Abort(MPI_COMM_WORLD, static_cast<int>(code));
  std::abort();
}

// Messages being sent to rank 0. The destructor waits for all of them.
class Outbox {
 public:
  Outbox() = default;
  Outbox(const Outbox&) = delete;
  Outbox& operator=(const Outbox&) = delete;
  ~Outbox() {
    for (Sent& sent : sent_) MPI_Wait(&sent.request, MPI_STATUS_IGNORE);
  }
  void send(std::uint64_t item, const std::string& bytes) {
    Sent& sent = sent_.emplace_back();
    sent.message = message_of(item, bytes);
    MPI_Isend(sent.message.data(), static_cast<int>(sent.message.size()), MPI_BYTE, 0, kTag,
              MPI_COMM_WORLD, &sent.request);
    while (!sent_.empty() && is_done(sent_.front())) sent_.pop_front();
  }

 private:
  struct Sent {
    std::string message;
    MPI_Request request = MPI_REQUEST_NULL;
  };
  static bool is_done(Sent& sent) {
    int done = 0;
    MPI_Test(&sent.request, &done, MPI_STATUS_IGNORE);
    return done != 0;
  }
  std::deque<Sent> sent_;
};

// Receives the probed message.
void receive(MPI_Status probed, const Ranks::Result& done) {
  int size = 0;
  MPI_Get_count(&probed, MPI_BYTE, &size);
  std::string message(static_cast<std::size_t>(size), '\0');
  MPI_Recv(message.data(), size, MPI_BYTE, probed.MPI_SOURCE, kTag, MPI_COMM_WORLD,
           MPI_STATUS_IGNORE);
  std::uint64_t item = 0;
  std::memcpy(&item, message.data(), sizeof item);
  const std::string bytes = message.substr(sizeof item);
  if (item == kFailed) abort_job(bytes.substr(1), static_cast<ExitCode>(bytes.front()));
  done(item, bytes);
}

}  // namespace

Ranks::Ranks() {
  if (!started_by_mpirun()) return;
  MPI_Init(nullptr, nullptr);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
  // All ranks find the same errors of the command line; only rank 0 reports them.
  if (rank_ != 0) spdlog::set_level(spdlog::level::off);
}

Ranks::~Ranks() {
  int running = 0;
  MPI_Initialized(&running);
  if (running != 0) MPI_Finalize();
}

int Ranks::lead(const std::function<int()>& action) const {
  if (size_ == 1) return action();
  try {
    return action();
  } catch (const Error& error) {
    abort_job(error.what(), error.code());
  }
}

std::vector<std::uint64_t> Ranks::share(std::vector<std::uint64_t> items) const {
  if (size_ == 1) return items;
  std::uint64_t count = items.size();
  MPI_Bcast(&count, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
  items.resize(count);
  MPI_Bcast(items.data(), static_cast<int>(count), MPI_UINT64_T, 0, MPI_COMM_WORLD);
  return items;
}

void Ranks::work(
    const std::vector<std::uint64_t>& items,
    const std::function<void(const std::vector<std::uint64_t>& mine, const Result&)>& work,
    const Result& done) const {
  if (size_ == 1) return work(items, done);
  std::vector<std::uint64_t> mine;
  for (std::size_t i = static_cast<std::size_t>(rank_); i < items.size();
       i += static_cast<std::size_t>(size_)) {
    mine.push_back(items[i]);
  }
  if (rank_ != 0) {
    Outbox outbox;
    const auto send = [&](std::uint64_t item, const std::string& bytes) {
      outbox.send(item, bytes);
    };
    try {
      return work(mine, send);
    } catch (const Error& error) {
      outbox.send(kFailed, static_cast<char>(error.code()) + std::string(error.what()));
      return;
    }
  }
  std::size_t missing = items.size() - mine.size();
  work(mine, [&](std::uint64_t item, const std::string& bytes) {
    done(item, bytes);
    MPI_Status probed;
    for (int waiting = 0;; --missing) {
      MPI_Iprobe(MPI_ANY_SOURCE, kTag, MPI_COMM_WORLD, &waiting, &probed);
      if (waiting == 0) break;
      receive(probed, done);
    }
  });
  for (; missing > 0; --missing) {
    MPI_Status probed;
    MPI_Probe(MPI_ANY_SOURCE, kTag, MPI_COMM_WORLD, &probed);
    receive(probed, done);
  }
}

}  // namespace chasles::app

#else

namespace chasles::app {

Ranks::Ranks() = default;
Ranks::~Ranks() = default;

int Ranks::lead(const std::function<int()>& action) const { return action(); }

std::vector<std::uint64_t> Ranks::share(std::vector<std::uint64_t> items) const { return items; }

void Ranks::work(
    const std::vector<std::uint64_t>& items,
    const std::function<void(const std::vector<std::uint64_t>& mine, const Result&)>& work,
    const Result& done) const {
  work(items, done);
}

}  // namespace chasles::app

#endif
