#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace chasles::app {

/// The processes of an MPI job (`mpirun -n K chasles ...`), or the one process that there is
/// without mpirun, or without MPI at build time (CMake's CHASLES_MPI). Rank 0 speaks for all: it
/// has the files and the terminal.
class Ranks {
 public:
  Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
  ~Ranks();

  int size() const { return size_; }
  bool first() const { return rank_ == 0; }

  /// What rank 0 does, files and all. An error of its own ends the whole job with its exit code.
  int lead(const std::function<int()>& action) const;

  /// Gives rank 0's items to all; every rank has to call it.
  std::vector<std::uint64_t> share(std::vector<std::uint64_t> items) const;

  /// Rank r does the items r, r + size, ... work(mine, result) calls
  /// result(item, bytes) for each; done(item, bytes) then gets it, in rank 0, in no certain order.
  /// An error of another rank is told by rank 0 and ends the job with its exit code. Every rank has
  /// to call it, with the same items.
  using Result = std::function<void(std::uint64_t item, const std::string& bytes)>;
  void work(const std::vector<std::uint64_t>& items,
            const std::function<void(const std::vector<std::uint64_t>& mine, const Result&)>& work,
            const Result& done) const;

 private:
  int rank_ = 0, size_ = 1;
};

}  // namespace chasles::app
