#pragma once

#include <string_view>

// What a program prints. Names of recordings, sessions, topics and files are anybody's: control
// characters in them would command the terminal, so they are printed as `\u001b`.
namespace chasles {

/// Prints to stdout. Throws UsageError if that is not possible.
void print_text(std::string_view text);

/// The same to stderr. A stderr that cannot be written is no error.
void note_text(std::string_view text);

/// Writes what stdout still holds. Throws UsageError if that is not possible.
void flush_stdout();

/// Log messages of this program go to stderr as `NAME: error: …`. `threads`: of several threads.
void log_to_stderr(const char* name, bool threads = false);

}  // namespace chasles
