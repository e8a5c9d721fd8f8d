#include <algorithm>
#include <charconv>
#include <map>
#include <optional>

#include <fmt/format.h>

#include <chasles/calibrate/target_images.hpp>
#include <chasles/codec/image_decode.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// Of one instant: the file of each camera, empty where it has none.
struct Shot {
  Time time{};
  std::vector<fs::path> files;
};

class TargetImages : public ImageSource {
 public:
  TargetImages(std::vector<Shot> shots, std::vector<ImageSize> sizes)
      : shots_(std::move(shots)), sizes_(std::move(sizes)) {}

  std::size_t size() const override { return shots_.size(); }
  Time time(std::size_t i) const override { return shots_[i].time; }
  ImageFrame read(std::size_t i) const override {
    return read_undamaged(i, sizes_.size(), throw_damage);
  }
  ImageFrame read_undamaged(std::size_t i, std::size_t cameras,
                            const OnDamage& damaged) const override {
    ImageFrame frame{.time = shots_[i].time, .images = {}};
    for (std::size_t c = 0; c < std::min(cameras, sizes_.size()); ++c) {
      const fs::path& file = shots_[i].files[c];
      frame.images.push_back(
          file.empty() ? GrayImage{}
                       : read_or_empty([&] { return read_image(file, sizes_[c]); }, damaged));
    }
    return frame;
  }
  bool has_image(std::size_t i, std::size_t camera) const override {
    return !shots_[i].files[camera].empty();
  }

 private:
  std::vector<Shot> shots_;
  std::vector<ImageSize> sizes_;
};

std::vector<fs::path> images_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_regular_file(error) && is_image_name(entry.path().filename().string())) {
      files.push_back(entry.path());
    }
  }
  std::ranges::sort(files);
  return files;
}

// The folders of the cameras: cam0, cam1, … in the folder or in images/, or the folder itself.
std::vector<fs::path> camera_folders(const fs::path& folder) {
  std::error_code error;
  for (const fs::path& above : {folder, folder / "images"}) {
    std::vector<fs::path> cameras;
    for (int c = 0;; ++c) {
      const fs::path camera = above / fmt::format("cam{}", c);
      if (!fs::is_directory(camera, error) || images_in(camera).empty()) break;
      cameras.push_back(camera);
    }
    if (!cameras.empty()) return cameras;
  }
  return {folder};
}

std::optional<std::int64_t> nanoseconds_of(const std::string& stem) {
  constexpr std::size_t kDigits = 10;
  std::int64_t value = 0;
  const char* end = stem.data() + stem.size();
  const auto [last, fault] = std::from_chars(stem.data(), end, value);
  if (fault != std::errc{} || last != end || stem.size() < kDigits) return std::nullopt;
  return value;
}

}  // namespace

bool is_target_images(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) return false;
  const std::vector<fs::path> cameras = camera_folders(folder);
  if (images_in(cameras.front()).empty()) return false;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string ending = entry.path().extension().string();
    if (ending == ".yaml" || ending == ".yml" || ending == ".json" || ending == ".csv" ||
        ending == ".txt" || entry.path().filename() == "mav0") {
      return false;
    }
  }
  return true;
}

Recording read_target_images(const fs::path& folder) {
  const std::vector<fs::path> cameras = camera_folders(folder);
  std::map<std::string, std::vector<fs::path>> by_name;
  std::vector<ImageSize> sizes;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const std::vector<fs::path> files = images_in(cameras[c]);
    if (files.empty()) {
      throw InputError(
          fmt::format("{}: found no images, expected those of a target", cameras[c].string()));
    }
    sizes.push_back(stated_size(read_file(files.front()), files.front().string()));
    for (const fs::path& file : files) {
      std::vector<fs::path>& shot = by_name[file.stem().string()];
      shot.resize(cameras.size());
      shot[c] = file;
    }
  }
  const bool has_times = std::ranges::all_of(
      by_name, [](const auto& one) { return nanoseconds_of(one.first).has_value(); });
  std::vector<Shot> shots;
  for (auto& [name, files] : by_name) {
    const std::int64_t index = static_cast<std::int64_t>(shots.size());
    shots.push_back({.time = Time(has_times ? *nanoseconds_of(name) : index * 1'000'000'000),
                     .files = std::move(files)});
  }
  std::ranges::stable_sort(shots, {}, [](const Shot& shot) { return shot.time; });
  Recording recording;
  recording.name = folder.filename().empty() ? folder.parent_path().filename().string()
                                             : folder.filename().string();
  for (const ImageSize& size : sizes) {
    recording.cameras.push_back({.width = size.width, .height = size.height, .cam_T_imu = {}});
  }
  recording.images = std::make_shared<TargetImages>(std::move(shots), std::move(sizes));
  return recording;
}

}  // namespace chasles
