#include <array>
#include <fstream>

#include <fmt/format.h>

#include <chasles/data/readers.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

constexpr const char* kKnownKinds =
    "an ECE276A .npz archive, a STARS .mat file, or a recording folder with calibration.yaml "
    "(docs/formats.md)";

std::string first_bytes(const std::filesystem::path& file) {
  std::array<char, 128> bytes{};
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(fmt::format("{}: cannot be opened", file.string()));
  stream.read(bytes.data(), bytes.size());
  return {bytes.data(), static_cast<std::size_t>(stream.gcount())};
}

}  // namespace

Recording read_recording(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    throw InputError(
        fmt::format("{}: no such file or folder, expected {}", path.string(), kKnownKinds));
  }
  if (std::filesystem::is_directory(path, ignored)) {
    if (std::filesystem::exists(path / "calibration.yaml", ignored)) {
      return read_folder_recording(path);
    }
    throw InputError(fmt::format("{}: the folder holds no calibration.yaml, expected {}",
                                 path.string(), kKnownKinds));
  }
  const std::string bytes = first_bytes(path);
  if (bytes.starts_with("PK\x03\x04") || bytes.starts_with("PK\x05\x06")) {
    return read_npz_recording(path);
  }
  if (bytes.starts_with("MATLAB 5.0") || bytes.starts_with("MATLAB 7.3") ||
      bytes.starts_with("\x89HDF\r\n")) {
    return read_mat_recording(path);
  }
  throw InputError(fmt::format("{}: {}, expected {}", path.string(),
                               bytes.empty() ? "is empty" : "its first bytes are of no known kind",
                               kKnownKinds));
}

}  // namespace chasles
