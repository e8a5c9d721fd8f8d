#pragma once

#include <pybind11/pybind11.h>

// Processes that are forks of this one (multiprocessing, os.fork). A fork has none of the threads
// of its parent: what one of them held or had half done stays so for ever.
namespace chasles::python {

/// Registers the functions for os.register_at_fork.
void watch_forks();

/// The number of forks between this process and the one that imported the module.
int fork_generation();

/// While it lives, this thread has something half done that a fork could not use.
class UnfitForForks {
 public:
  UnfitForForks();
  ~UnfitForForks();
  UnfitForForks(const UnfitForForks&) = delete;
  UnfitForForks& operator=(const UnfitForForks&) = delete;
};

/// Throws UsageError, which names the start method `spawn`, in a process that was forked while an
/// estimator or a reader of its parent worked.
void reject_after_fork();
/// The same for an object with a thread of its own, made in that generation.
void reject_thread_of(int generation, const char* what);

}  // namespace chasles::python
