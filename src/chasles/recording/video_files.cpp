#include <algorithm>
#include <array>
#include <cctype>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/video_files.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

bool is_video_name(const fs::path& file) {
  const std::string ending = lower_case(file.extension().string());
  return (ending == ".mp4" || ending == ".mov") && !file.filename().string().starts_with(".");
}

bool are_digits(std::string_view text) {
  return std::ranges::all_of(text, [](unsigned char c) { return std::isdigit(c) != 0; });
}

}  // namespace

fs::path VideoPlace::beside(const std::string& ending) const {
  return folder / (video.stem().string() + ending);
}

std::optional<fs::path> VideoPlace::first_of(const std::vector<std::string>& own,
                                             const std::vector<std::string>& shared) const {
  std::error_code ignored;
  for (const std::string& ending : own) {
    if (fs::is_regular_file(beside(ending), ignored)) return beside(ending);
  }
  if (!is_alone) return std::nullopt;
  for (const std::string& name : shared) {
    if (fs::is_regular_file(folder / name, ignored)) return folder / name;
  }
  return std::nullopt;
}

bool is_video_file(const fs::path& file, std::string_view first_bytes) {
  constexpr std::array<std::string_view, 7> kBoxes{"ftyp", "moov", "mdat", "wide",
                                                   "free", "skip", "pnot"};
  const std::string_view box = first_bytes.substr(std::min<std::size_t>(4, first_bytes.size()), 4);
  const std::string ending = lower_case(file.extension().string());
  return std::ranges::find(kBoxes, box) != kBoxes.end() && ending != ".insv";
}

std::vector<fs::path> videos_in(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (is_video_name(entry.path()) && entry.is_regular_file(ignored)) {
      found.push_back(entry.path());
    }
  }
  std::ranges::sort(found);
  return found;
}

VideoPlace find_video(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_directory(path, ignored)) {
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    return {.video = path, .folder = folder, .is_alone = videos_in(folder).size() <= 1};
  }
  const std::vector<fs::path> videos = videos_in(path);
  if (videos.size() == 1) {
    return {.video = videos[0], .folder = path, .is_alone = true, .by_folder = true};
  }
  std::string names;
  constexpr std::size_t kNamed = 3;
  for (std::size_t i = 0; i < std::min(kNamed, videos.size()); ++i) {
    names += fmt::format("{}{}", i > 0 ? ", " : "", videos[i].filename().string());
  }
  throw InputError(fmt::format("{}: has {} videos ({}{}), expected one: give one of them",
                               path.string(), videos.size(), names,
                               videos.size() > kNamed ? ", ..." : ""));
}

std::optional<fs::path> next_chapter(const fs::path& video) {
  const std::string name = video.filename().string(), stem = video.stem().string();
  constexpr std::size_t kLength = 8;  // GX010001: the chapter, and the number of the recording
  if (stem.size() != kLength || stem[0] != 'G') return std::nullopt;
  const std::string number = stem.substr(4), chapter = stem.substr(2, 2);
  std::string next;
  if (stem.starts_with("GOPR") && are_digits(number)) {
    next = fmt::format("GP01{}", number);
  } else if (are_digits(number) && are_digits(chapter)) {
    next = fmt::format("{}{:02}{}", stem.substr(0, 2), std::stoi(chapter) + 1, number);
  }
  const fs::path file = video.parent_path() / (next + video.extension().string());
  std::error_code ignored;
  return !next.empty() && fs::is_regular_file(file, ignored) ? std::optional(file) : std::nullopt;
}

}  // namespace chasles
