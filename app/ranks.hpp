#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace chasles::app {

/// The processes of an MPI job (`mpirun -n K chasles ...`). Without mpirun, or without MPI at build
/// time (CMake's CHASLES_MPI), there is one process. Only rank 0 uses files and the terminal.
class Ranks {
 public:
  Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
  ~Ranks();

  int size() const { return size_; }
  bool first() const { return rank_ == 0; }

  /// Runs the action of rank 0 and returns its exit code. An error in it ends the whole job with
  /// the exit code of the error.
  int lead(const std::function<int()>& action) const;

  /// Broadcasts the items of rank 0. Every rank must call it.
  std::vector<std::uint64_t> share(std::vector<std::uint64_t> items) const;

  /// Distributes items: rank r processes the items r, r + size, ... Its work(mine, result) calls
  /// result(item, bytes) for each of them. Rank 0 receives them by done(item, bytes), in any order.
  /// Rank 0 reports an error of another rank, and the job ends with the exit code of the error.
  /// Every rank must call it, with the same items.
  using Result = std::function<void(std::uint64_t item, const std::string& bytes)>;
  void work(const std::vector<std::uint64_t>& items,
            const std::function<void(const std::vector<std::uint64_t>& mine, const Result&)>& work,
            const Result& done) const;

 private:
  int rank_ = 0, size_ = 1;
};

}  // namespace chasles::app
