#include "parts.hpp"

#include <algorithm>

#include <chasles/recording/testing.hpp>

namespace chasles::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMark = "\n=== ";
constexpr std::size_t kLongestName = 100;

bool harmless(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '.' || c == '-';
}

// No parent folder, and no name that is only dots or empty.
std::string tame(std::string_view name) {
  std::string tamed;
  for (const char c : name.substr(0, kLongestName)) {
    const bool begins = tamed.empty() || tamed.back() == '/';
    if (c == '/' && begins) continue;
    tamed += c == '/' || (harmless(c) && !(begins && c == '.')) ? c : '_';
  }
  if (tamed.empty() || tamed.back() == '/') tamed += '_';
  return tamed;
}

}  // namespace

std::string pack(const Parts& parts) {
  std::string bytes;
  for (const auto& [name, text] : parts) bytes.append(kMark).append(name).append("\n").append(text);
  return bytes;
}

Parts unpack(std::string_view bytes) {
  Parts parts;
  for (std::size_t at = bytes.find(kMark); at != std::string_view::npos;) {
    const std::size_t next = bytes.find(kMark, at + 1);
    const std::string_view part = bytes.substr(at + kMark.size(), next - at - kMark.size());
    const std::size_t line = std::min(part.find('\n'), part.size());
    const std::string_view text = part.substr(std::min(line + 1, part.size()));
    parts.emplace_back(tame(part.substr(0, line)), text);
    at = next;
  }
  return parts;
}

Parts parts_of(const fs::path& folder) {
  Parts parts;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    parts.emplace_back(entry.path().lexically_relative(folder), test::slurp(entry.path()));
  }
  // The order of a directory's entries depends on the file system.
  std::sort(parts.begin(), parts.end());
  return parts;
}

void lay_out(const fs::path& folder, std::string_view bytes) {
  fs::remove_all(folder);
  fs::create_directories(folder);
  for (const auto& [name, text] : unpack(bytes)) {
    std::error_code ignored;  // a mutated name may be a file and a folder
    fs::create_directories((folder / name).parent_path(), ignored);
    test::spill(folder / name, text);
  }
}

}  // namespace chasles::fuzz
