#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <optional>
#include <thread>
#include <vector>

#include <chasles/base/interruption.hpp>

namespace chasles {

/// Calls work(0), work(1), ... work(count - 1), each once and in any order, by at most `threads`
/// threads, the calling one among them. Work that throws ends the others after their present item;
/// the exception of the lowest item is thrown on. An interruption of the calling thread reaches the
/// others.
template <typename Work>
void in_parallel(std::size_t count, int threads, const Work& work) {
  std::vector<std::exception_ptr> faults(count);
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> stop = false;
  const auto take_turns = [&] {
    for (std::size_t i = next++; i < count && !stop; i = next++) {
      try {
        work(i);
      } catch (...) {
        faults[i] = std::current_exception();
        stop = true;
      }
    }
  };
  {
    CallProgress* const call = ObservedCall::current();
    const auto work_of_thread = [&] {
      std::optional<ObservedCall> observed;
      if (call != nullptr) observed.emplace(*call);
      take_turns();
    };
    std::vector<std::jthread> others;
    for (std::size_t i = 1; i < count && i < static_cast<std::size_t>(threads); ++i) {
      others.emplace_back(work_of_thread);
    }
    take_turns();
  }
  for (const std::exception_ptr& fault : faults) {
    if (fault) std::rethrow_exception(fault);
  }
}

}  // namespace chasles
