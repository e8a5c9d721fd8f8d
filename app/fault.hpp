#pragma once

#include <exception>
#include <string>

namespace chasles::app {

/// What ended the program: a sentence for the user, and the exit code (docs/command-line.md).
struct Fault {
  std::string sentence;
  int code = 70;
};

/// Of Error, and of what the system denied: memory, threads, descriptors, room for files. Anything
/// else is an internal error. Where the working folder was removed, the sentence says so.
Fault fault_of(const std::exception& error);

/// Makes a file that reaches the limit of sizes (ulimit -f) an error of its writer. Otherwise the
/// system ends the program without a word.
void report_file_limit();

}  // namespace chasles::app
