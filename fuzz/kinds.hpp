#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace chasles::fuzz {

/// A way into the readers: bytes become a file (or several), which is then read.
struct Kind {
  std::string_view name;
  /// The bytes of a small valid recording; `scratch` is a folder to make it in.
  std::string (*seed)(const std::filesystem::path& scratch);
  /// Writes the bytes below `scratch` and reads them. Throws InputError where they are malformed,
  /// and must do nothing worse whatever they are.
  void (*read)(const std::filesystem::path& scratch, std::string_view bytes);
};

/// npz, mat and tum take a file's bytes; `npy` the arrays of an archive (put together with the
/// right check sums), `folder` the files of a recording folder: parts with "=== NAME" lines.
std::span<const Kind> kinds();

/// Makes a folder of this process' own, in memory where the system has that.
std::filesystem::path make_scratch();

}  // namespace chasles::fuzz
