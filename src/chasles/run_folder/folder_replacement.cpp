#include <algorithm>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>
#include <zlib.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/json_text.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/run_folder/folder_replacement.hpp>
#include <chasles/run_folder/shown_images.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char *kWriting = ".writing", *kWritten = ".written", *kSummaryFile = "summary.json",
                     *kFiles = "files";
// All files but summary.json and pictures of a run whose summary does not list them (before 0.2).
constexpr const char* kRunFiles[] = {"trajectory.tum",
                                     "states.csv",
                                     "timing.csv",
                                     "landmarks.csv",
                                     "map.ply",
                                     "truth.tum",
                                     "plan.csv",
                                     "images.csv",
                                     "features.csv",
                                     "timing.json",
                                     "dead_reckoning.tum",
                                     "smoothed.csv",
                                     "trajectory_smoothed.tum",
                                     "in_map.csv",
                                     "prior_map.csv",
                                     "trajectory_in_map.tum"};

// Their content differs from run to run, so summary.json cannot describe it.
bool is_timing(const std::string& name) { return name.starts_with("timing."); }

std::vector<std::string> files_below(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_directory()) continue;
    names.push_back(entry.path().lexically_relative(folder).generic_string());
  }
  std::ranges::sort(names);
  return names;
}

struct Content {
  std::uintmax_t bytes = 0;
  std::string crc32;
};

std::optional<Content> content_of(const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return std::nullopt;
  std::ifstream stream(file, std::ios::binary);
  std::vector<char> buffer(1 << 20);
  Content content;
  uLong sum = ::crc32_z(0, nullptr, 0);
  while (stream) {
    stream.read(buffer.data(), std::ssize(buffer));
    const auto count = static_cast<std::size_t>(stream.gcount());
    sum = ::crc32_z(sum, reinterpret_cast<const Bytef*>(buffer.data()), count);
    content.bytes += count;
  }
  if (!stream.eof()) return std::nullopt;
  content.crc32 = fmt::format("{:08x}", sum);
  return content;
}

Json to_json(const Content& content) {
  return {{"bytes", content.bytes}, {"crc32", content.crc32}};
}

// The entry `files` of the new summary. Every file is on the disk afterwards.
Json described(const fs::path& folder) {
  Json files = Json::object();
  for (const std::string& name : files_below(folder)) {
    sync_to_disk(folder / name);
    if (is_timing(name)) {
      files[name] = nullptr;
      continue;
    }
    const std::optional<Content> content = content_of(folder / name);
    if (!content) throw UsageError((folder / name).string() + ": cannot be read again");
    files[name] = to_json(*content);
  }
  return files;
}

void sync_folders(const fs::path& folder) {
  std::error_code ignored;
  if (fs::is_directory(folder / "images", ignored)) sync_to_disk(folder / "images");
  sync_to_disk(folder);
}

// After the files are committed nothing may be in their way.
void check_way(const fs::path& folder, const Json& files) {
  const auto check = [&](const std::string& name) {
    const fs::path file = folder / name, above = file.parent_path();
    if (fs::is_directory(fs::symlink_status(file))) {
      throw UsageError(
          fmt::format("{}: is a folder, in the way of a file of the run; move it", file.string()));
    }
    if (fs::exists(fs::symlink_status(above)) && !fs::is_directory(above)) {
      throw UsageError(
          fmt::format("{}: is a file, in the way of a folder of the run; move it", above.string()));
    }
  };
  check(kSummaryFile);
  for (const auto& [name, content] : files.items()) check(name);
}

Json committed_summary(const fs::path& file) {
  Json summary = parse_json_object(read_file(file), file.string());
  if (summary.contains(kFiles) && summary.at(kFiles).is_object()) {
    return summary;
  }
  throw InputError(
      fmt::format("{}: expected a JSON object with the entry '{}'", file.string(), kFiles));
}

// Whether it is a place of a run's files. A summary is the user's to change.
bool is_run_file(const std::string& name) {
  const std::string_view plain =
      name.starts_with("images/") ? std::string_view(name).substr(7) : name;
  return plain.find('/') == std::string_view::npos && plain != "." && plain != "..";
}

// The files of the run in the folder; empty without one. Other files of the folder are not its own.
std::vector<std::string> earlier_files(const fs::path& folder) {
  std::error_code ignored;
  std::vector<std::string> names;
  if (!fs::is_regular_file(folder / kSummaryFile, ignored)) return names;
  const Json summary = Json::parse(read_file(folder / kSummaryFile), nullptr, false);
  if (!summary.is_object()) return names;
  const auto files = summary.find(kFiles);
  if (files == summary.end()) {
    names.assign(std::begin(kRunFiles), std::end(kRunFiles));
    std::ranges::copy(pictures_of(folder), std::back_inserter(names));
  } else if (files->is_object()) {
    for (const auto& [name, content] : files->items()) names.push_back(name);
  }
  std::erase_if(names, [](const std::string& name) { return !is_run_file(name); });
  return names;
}

// May begin again after any of its steps.
void move_up(const fs::path& folder) {
  const fs::path from = folder / kWritten;
  if (fs::exists(from / kSummaryFile)) {
    const Json files = committed_summary(from / kSummaryFile).at(kFiles);
    for (const std::string& name : earlier_files(folder)) {
      if (!files.contains(name)) fs::remove(folder / name);
    }
    fs::remove(folder / kSummaryFile);
    for (const std::string& name : files_below(from)) {
      if (name == kSummaryFile) continue;
      fs::create_directories((folder / name).parent_path());
      fs::rename(from / name, folder / name);
    }
    sync_folders(folder);
    fs::rename(from / kSummaryFile, folder / kSummaryFile);
    sync_to_disk(folder);
  }
  fs::remove_all(from);
  std::error_code not_empty;
  fs::remove(folder / "images", not_empty);
}

}  // namespace

FolderReplacement::FolderReplacement(const fs::path& folder)
    : folder_(folder), writing_(folder / kWriting) {
  make_folder(folder_);
  finish_replacement(folder_);
  discard_unfinished(folder_);
  make_folder(writing_);
}

FolderReplacement::~FolderReplacement() {
  std::error_code ignored;
  fs::remove_all(writing_, ignored);
}

Json FolderReplacement::commit(Json summary) {
  try {
    summary[kFiles] = described(writing_);
    check_way(folder_, summary.at(kFiles));
    write_file(writing_ / kSummaryFile, json_text(summary, 2) + "\n");
    sync_to_disk(writing_ / kSummaryFile);
    sync_folders(writing_);
    const FolderLock lock(folder_);
    fs::rename(writing_, folder_ / kWritten);
    sync_to_disk(folder_);
    move_up(folder_);
  } catch (const fs::filesystem_error& error) {
    throw UsageError(
        fmt::format("{}: the run cannot be written: {}", folder_.string(), error.code().message()));
  }
  return summary;
}

void finish_replacement(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::exists(folder / kWritten, ignored)) return;
  const FolderLock lock(folder);
  try {
    if (fs::exists(folder / kWritten)) move_up(folder);
  } catch (const fs::filesystem_error& error) {
    throw InputError(fmt::format(
        "{0}: a run was ended while its files were moved out of {0}/{1}, and they cannot be moved "
        "now: {2}; expected a folder that can be written, or the files moved by hand",
        folder.string(), kWritten, error.code().message()));
  }
}

void discard_unfinished(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(fs::symlink_status(folder / kWriting, error))) return;
  fs::remove_all(folder / kWriting, error);
  if (!error) return;
  throw UsageError(fmt::format("{}: the remains of a run that was killed cannot be removed: {}",
                               (folder / kWriting).string(), error.message()));
}

void check_run_files(const fs::path& folder, const Json& summary) {
  const auto files = summary.find(kFiles);
  if (files == summary.end()) return;
  const auto reject = [&](const std::string& name, const std::string& found) {
    throw InputError(fmt::format(
        "{}: {}: the file is of another run, changed, or a copy that was cut off; copy the folder "
        "again, or run again (without the entry '{}' in summary.json nothing is compared)",
        (folder / name).string(), found, kFiles));
  };
  if (!files->is_object()) reject(kSummaryFile, "'files' is no JSON object");
  for (const auto& [name, stated] : files->items()) {
    const std::optional<Content> content = content_of(folder / name);
    if (!content) reject(name, "cannot be read, but summary.json lists it");
    if (stated.is_null()) continue;
    const Json found = to_json(*content);
    if (found != stated) {
      reject(name,
             fmt::format("is {}, summary.json states {}", json_text(found), json_text(stated)));
    }
  }
}

}  // namespace chasles
