#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace chasles {

/// Does work(item) for every item in so many processes of this machine and gives what it returns to
/// done(item, result), in this process, in no certain order. Processes, not threads: Debian's
/// serial OpenBLAS may not be called from two threads at a time, and a fault in one item does not
/// take the others' results along. An exception of `work` is rethrown as an Error with its message
/// once the others have stopped; a worker that dies is an Error as well. With one worker all is
/// done here.
void work_in_processes(std::span<const std::uint64_t> items, int workers,
                       const std::function<std::string(std::uint64_t item)>& work,
                       const std::function<void(std::uint64_t item, const std::string&)>& done);

}  // namespace chasles
