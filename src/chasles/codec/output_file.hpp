#pragma once

#include <filesystem>
#include <string_view>

// Files that are written, whatever their names stand for.
namespace chasles {

/// Opens a file for writing, and empties it. Never waits for the reader of a pipe: throws
/// UsageError for a pipe that nobody reads and for a socket, and where the file cannot be opened.
/// The caller closes the descriptor.
int open_to_write(const std::filesystem::path& file);

/// Writes all bytes at the descriptor's position. `file` is for the message of UsageError.
void write_all(int descriptor, std::string_view bytes, const std::filesystem::path& file);

/// The file that a name stands for: links are followed, also one whose file does not exist yet.
/// Throws UsageError for links that lead back to themselves, and into a folder that does not exist.
std::filesystem::path followed(const std::filesystem::path& file);

/// Throws UsageError for a pipe or a socket that has a name of its own: what must be there at the
/// end of a long run goes into a file. /dev/stdout may be a pipe.
void reject_pipe(const std::filesystem::path& file);

}  // namespace chasles
