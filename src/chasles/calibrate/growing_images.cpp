#include <algorithm>

#include <chasles/calibrate/growing_images.hpp>
#include <chasles/calibrate/target_images.hpp>
#include <chasles/codec/image_decode.hpp>

namespace chasles {

namespace fs = std::filesystem;

std::optional<FileState> FileState::of(const fs::path& file) {
  std::error_code error;
  FileState state;
  state.size = fs::file_size(file, error);
  if (error) return std::nullopt;
  state.written = fs::last_write_time(file, error);
  return error ? std::nullopt : std::optional(state);
}

void GrowingImages::poll() {
  const std::vector<fs::path> folders = target_image_folders(folder_);
  for (std::size_t c = 0; c < folders.size(); ++c) find_new(c, folders[c]);
  for (auto& [name, entry] : waiting_) check(entry);
  for (const auto& [name, entry] : waiting_) {
    if (are_whole(entry) && entry.files.size() == cameras_) {
      newest_whole_ = std::max(newest_whole_, entry.place);
    }
  }
}

std::optional<GrowingImages::Shot> GrowingImages::take() {
  for (auto place = order_.rbegin(); place != order_.rend(); ++place) {
    const auto found = waiting_.find(place->second);
    const Entry& entry = found->second;
    const bool is_last = entry.files.size() < cameras_ && entry.place >= newest_whole_;
    if (entry.damaged || is_last || !are_whole(entry)) continue;
    Shot shot{.name = found->first,
              .files = std::vector<fs::path>(cameras_),
              .states = std::vector<FileState>(cameras_)};
    for (const auto& [camera, file] : entry.files) {
      shot.files[camera] = file.path;
      shot.states[camera] = file.state;
    }
    order_.erase(std::next(place).base());
    waiting_.erase(found);
    return shot;
  }
  return std::nullopt;
}

void GrowingImages::put_back(const Shot& shot) {
  Entry entry{.place = arrived_++, .damaged = true};
  for (std::size_t c = 0; c < shot.files.size(); ++c) {
    if (shot.files[c].empty()) continue;
    entry.files[c] = {.path = shot.files[c], .state = shot.states[c]};
  }
  order_[entry.place] = shot.name;
  waiting_[shot.name] = std::move(entry);
}

// Names of one poll have no order of arrival: shorter numbers are smaller ones.
void GrowingImages::find_new(std::size_t camera, const fs::path& images) {
  if (known_.size() <= camera) known_.resize(camera + 1);
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator at(images, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (is_image_name(name) && known_[camera].insert(name).second) files.push_back(at->path());
  }
  std::ranges::sort(files, {}, [](const fs::path& file) {
    return std::pair(file.native().size(), file.native());
  });
  for (const fs::path& file : files) {
    cameras_ = std::max(cameras_, camera + 1);
    names_.insert(file.stem().string());
    const auto [entry, is_new] = waiting_.try_emplace(file.stem().string());
    if (is_new) {
      entry->second.place = arrived_++;
      order_[entry->second.place] = entry->first;
    }
    entry->second.files[camera].path = file;
  }
}

void GrowingImages::check(Entry& entry) {
  for (auto& [camera, file] : entry.files) {
    if (file.whole) continue;
    const std::optional<FileState> now = FileState::of(file.path);
    file.whole = now && now->size > 0 && *now == file.state && !entry.damaged;
    if (now && *now != file.state) entry.damaged = false;
    file.state = now.value_or(FileState{});
  }
}

bool GrowingImages::are_whole(const Entry& entry) const {
  return std::ranges::all_of(entry.files, [](const auto& one) { return one.second.whole; });
}

}  // namespace chasles
