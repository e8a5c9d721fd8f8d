#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace chasles {

/// Executes work(item) for every item in `workers` processes of this machine and passes its result
/// to done(item, result), in this process, in no fixed order. Processes are used instead of
/// threads, because Debian's serial OpenBLAS may not be called from two threads at a time, and
/// because a fault in one item then does not affect the results of the others. An exception of
/// `work` is rethrown as an Error with its message once the others have stopped; a worker that dies
/// is an Error as well. With one worker everything runs in this process, and exceptions stay what
/// they are.
void work_in_processes(std::span<const std::uint64_t> items, int workers,
                       const std::function<std::string(std::uint64_t item)>& work,
                       const std::function<void(std::uint64_t item, const std::string&)>& done);

}  // namespace chasles
