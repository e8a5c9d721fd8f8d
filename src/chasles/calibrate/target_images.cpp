#include <algorithm>
#include <map>
#include <optional>

#include <fmt/format.h>

#include <chasles/base/median.hpp>
#include <chasles/calibrate/target_images.hpp>
#include <chasles/codec/image_decode.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/time_text.hpp>
#include <chasles/recording/image_files.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/uncalibrated.hpp>
#include <chasles/target/target_file.hpp>

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
  fs::path file(std::size_t i, std::size_t camera) const { return shots_[i].files[camera]; }
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

bool has_images(const fs::path& folder) {
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (is_image_name(at->path().filename().string())) return true;
  }
  return false;
}

bool is_target_file(const fs::path& file) {
  try {
    read_target(file);
    return true;
  } catch (const Error&) {
    return false;
  }
}

// The number at the end of a name, and the text before it.
std::pair<std::string, std::string> before_and_number(const std::string& name) {
  std::size_t begin = name.find_last_not_of("0123456789.");
  begin = begin == std::string::npos ? 0 : begin + 1;
  while (begin < name.size() && name[begin] == '.') ++begin;
  return {name.substr(0, begin), name.substr(begin)};
}

// In the unit of the text; none where it is no stamp.
std::optional<Time> stamp_of(const std::string& number) {
  constexpr std::size_t kDigits = 10, kDate = 14;
  const bool is_whole = number.find('.') == std::string::npos;
  if (is_whole && (number.size() < kDigits || number.size() == kDate)) return std::nullopt;
  const auto written = written_time(number, *time_scale_named(is_whole ? "ns" : "s"));
  return written ? std::optional(written->time) : std::nullopt;
}

// Makes nanoseconds of whole numbers of any unit, by the median interval. False where these are no
// times of a camera.
bool make_nanoseconds(std::vector<Time>& stamps, bool is_whole) {
  constexpr double kLeast = 2e5;  // between two images [ns]
  std::vector<Time> sorted = stamps;
  std::ranges::sort(sorted);
  std::vector<double> intervals;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    intervals.push_back(static_cast<double>((sorted[i] - sorted[i - 1]).count()));
  }
  if (intervals.empty()) return true;
  const double interval = median(std::move(intervals));
  for (std::int64_t factor = 1; factor <= (is_whole ? 1'000'000 : 1); factor *= 1000) {
    if (sorted.back().count() >= kLastNanosecond / factor) return false;
    if (interval * static_cast<double>(factor) < kLeast) continue;
    for (Time& stamp : stamps) stamp *= factor;
    return true;
  }
  return false;
}

}  // namespace

std::vector<fs::path> target_image_folders(const fs::path& folder) {
  for (const fs::path& above : {folder, folder / "images", folder / "mav0"}) {
    std::vector<fs::path> cameras;
    for (int c = 0;; ++c) {
      const fs::path camera = above / fmt::format("cam{}", c);
      if (has_images(camera)) {
        cameras.push_back(camera);
      } else if (has_images(camera / "data")) {
        cameras.push_back(camera / "data");
      } else {
        break;
      }
    }
    if (!cameras.empty()) return cameras;
  }
  return {folder};
}

std::vector<Time> times_of_names(const std::vector<std::string>& names) {
  std::vector<Time> stamps;
  bool is_whole = true;
  for (const std::string& name : names) {
    const auto [before, number] = before_and_number(name);
    const std::optional<Time> stamp = stamp_of(number);
    if (!stamp || before != before_and_number(names.front()).first) break;
    stamps.push_back(*stamp);
    is_whole = is_whole && number.find('.') == std::string::npos;
  }
  if (stamps.size() == names.size() && make_nanoseconds(stamps, is_whole)) return stamps;
  stamps.clear();
  for (std::size_t i = 0; i < names.size(); ++i) {
    stamps.push_back(std::chrono::seconds(static_cast<std::int64_t>(i)));
  }
  return stamps;
}

fs::path target_image_file(const ImageSource& images, std::size_t i, std::size_t camera) {
  const auto* own = dynamic_cast<const TargetImages*>(&images);
  return own ? own->file(i, camera) : image_file(images, i, camera);
}

bool is_target_images(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) return false;
  const std::vector<fs::path> cameras = target_image_folders(folder);
  if (!has_images(cameras.front()) || cameras.front().filename() == "data") return false;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string ending = entry.path().extension().string();
    if (entry.path().filename() == "mav0") return false;
    if (ending == ".yaml" || ending == ".yml"
            ? !is_target_file(entry.path())
            : ending == ".json" || ending == ".csv" || ending == ".txt") {
      return false;
    }
  }
  return true;
}

Recording read_target_images(const fs::path& folder) {
  const std::vector<fs::path> cameras = target_image_folders(folder);
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
  std::vector<std::string> names;
  for (const auto& [name, files] : by_name) names.push_back(name);
  const std::vector<Time> times = times_of_names(names);
  std::vector<Shot> shots;
  for (auto& [name, files] : by_name) {
    shots.push_back({.time = times[shots.size()], .files = std::move(files)});
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

Recording read_target_recording(const fs::path& path) {
  if (is_target_images(path)) return read_target_images(path);
  return is_uncalibrated(path) ? read_uncalibrated(path) : read_recording(path);
}

}  // namespace chasles
