#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/image_decode.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/codec/time_text.hpp>
#include <chasles/recording/image_names.hpp>
#include <chasles/recording/image_times.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 5> kListNames{"times.txt", "timestamps.txt", "timestamps.csv",
                                                "timestamp.txt", "times.csv"};

std::vector<StampedFile> named_in_nanoseconds(const fs::path& folder,
                                              const std::vector<NumberedImage>& images) {
  std::vector<StampedFile> files;
  for (const NumberedImage& image : images) {
    const std::string where =
        fmt::format("{}: the name of an image without a times.csv", (folder / image.file).string());
    files.push_back({.time = parse_nanoseconds(where, image.number), .file = image.file});
  }
  return files;
}

std::vector<StampedFile> named_in_seconds(const fs::path& folder,
                                          const std::vector<NumberedImage>& images,
                                          const std::string& camera,
                                          std::vector<std::string>& remarks) {
  std::vector<std::string_view> texts;
  for (const NumberedImage& image : images) texts.emplace_back(image.number);
  const ColumnTimes times =
      read_unscaled_times(texts, [&](std::size_t i) { return (folder / images[i].file).string(); });
  std::vector<StampedFile> files;
  for (std::size_t i = 0; i < images.size(); ++i) {
    files.push_back({.time = times.times[i], .file = images[i].file});
  }
  if (std::string remark = times_remark("the names of the images of " + camera, times);
      !remark.empty()) {
    remarks.push_back(std::move(remark));
  }
  return files;
}

// The list of the times that counts for a camera.
std::optional<fs::path> find_list(const CameraPlace& place) {
  const fs::path beside = place.images.parent_path();
  std::vector<fs::path> candidates;
  for (const char* name : kListNames) candidates.push_back(place.images / name);
  for (const char* ending :
       {".txt", ".csv", "_times.txt", "_times.csv", "_timestamps.txt", "_timestamps.csv"}) {
    candidates.push_back(beside / (place.name + ending));
    candidates.push_back(beside / (place.images.filename().string() + ending));
  }
  for (const fs::path& folder : place.shared) {
    for (const char* name : kListNames) candidates.push_back(folder / name);
  }
  std::error_code ignored;
  for (const fs::path& file : candidates) {
    if (fs::is_regular_file(file, ignored)) return file;
  }
  return std::nullopt;
}

[[noreturn]] void no_times(const CameraPlace& place, const std::vector<NumberedImage>& images) {
  const auto odd = std::ranges::find(images, std::string(), &NumberedImage::number);
  throw InputError(fmt::format(
      "{}: the names of its {} images ({} to {}) are no times{}, and there is no list of them: "
      "expected {}, with a line `1403636584763555584 {}` for each image (nanoseconds, or seconds "
      "with decimals), or images that are named by their times in nanoseconds",
      place.images.string(), images.size(), images.front().file, images.back().file,
      odd == images.end() ? "" : fmt::format(", as '{}'", fs::path(odd->file).stem().string()),
      (place.images / kListNames.front()).string(), images.front().file));
}

std::vector<StampedFile> times_of_names(const CameraPlace& place,
                                        const std::vector<NumberedImage>& images,
                                        std::vector<std::string>& remarks) {
  const bool decimals = std::ranges::any_of(images, [](const NumberedImage& image) {
    return image.number.find('.') != std::string::npos;
  });
  return decimals ? named_in_seconds(place.images, images, place.name, remarks)
                  : named_in_nanoseconds(place.images, images);
}

// The one scale in which most frames are within the samples; none if nanoseconds are.
std::optional<TimeScale> fitting_scale(const std::vector<StampedFile>& images, Time begin,
                                       Time end) {
  const auto within = [&](std::int64_t factor) {
    return std::ranges::count_if(images, [&](const StampedFile& image) {
      const std::int64_t ns = image.time.count();
      const bool fits = std::abs(ns) < kLastNanosecond / factor;
      return fits && Time(ns * factor) >= begin && Time(ns * factor) <= end;
    });
  };
  if (images.empty() || within(1) > 0) return std::nullopt;
  for (const char* unit : {"us", "ms"}) {
    const TimeScale scale = *time_scale_named(unit);
    const std::int64_t factor = scale.digits == 3 ? 1000 : 1'000'000;
    if (2 * within(factor) > static_cast<std::int64_t>(images.size())) return scale;
  }
  return std::nullopt;
}

}  // namespace

std::optional<CameraFiles> list_camera_images(const CameraPlace& place,
                                              std::vector<std::string>& remarks) {
  std::error_code ignored;
  if (!fs::is_directory(place.images, ignored)) return std::nullopt;
  const fs::path table = place.images / "times.csv";
  if (fs::exists(table)) return read_image_list(table, place, remarks);
  const std::vector<NumberedImage> images = images_in(place.images);
  CameraFiles files{.folder = place.images, .images = {}};
  if (images.empty()) return files;
  if (are_numbers(images) && !are_counted(images)) {
    files.images = times_of_names(place, images, remarks);
    return files;
  }
  const auto list = find_list(place);
  if (!list) no_times(place, images);
  files = read_image_list(*list, place, remarks);
  remarks.push_back(fmt::format("the times of the images of {} are those of {}", place.name,
                                (list->parent_path().filename() / list->filename()).string()));
  return files;
}

void fit_units(std::vector<std::optional<CameraFiles>>& cameras, const std::vector<ImuSample>& imu,
               std::vector<std::string>& remarks) {
  if (imu.empty()) return;
  std::optional<TimeScale> scale;
  for (const auto& camera : cameras) {
    if (camera && !scale) scale = fitting_scale(camera->images, imu.front().time, imu.back().time);
  }
  if (!scale) return;
  for (auto& camera : cameras) {
    if (!camera) continue;
    for (StampedFile& image : camera->images) {
      const auto time = written_time(fmt::to_string(image.time.count()), *scale);
      if (time) image.time = time->time;
    }
  }
  remarks.push_back(fmt::format(
      "the times of the images are taken as {}: so they are within the samples of the IMU, and as "
      "nanoseconds none is",
      scale->name));
}

}  // namespace chasles
