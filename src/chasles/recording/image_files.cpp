#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/camera/rig_overlap.hpp>
#include <chasles/codec/image_decode.hpp>
#include <chasles/codec/image_range.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/image_files.hpp>
#include <chasles/recording/paired_images.hpp>
#include <chasles/recording/time_order.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr int kFoldersUp = 3;  // from mav0/cam0/data to the recording's folder

std::set<std::string> names_in(const fs::path& folder) {
  std::error_code error;
  fs::directory_iterator files(folder, error);
  if (error) {
    throw InputError(
        fmt::format("{}: no such folder, expected the images of a camera there", folder.string()));
  }
  std::set<std::string> names;
  for (const fs::directory_entry& entry : files) names.insert(entry.path().filename().string());
  return names;
}

// What the images of a camera must be, and how their values become grey.
struct ImageForm {
  ImageSize size;
  int bits = kAllBits;
};

class ImageFiles : public PairedImages {
 public:
  ImageFiles(std::vector<CameraFiles> cameras, std::vector<ImageForm> forms,
             std::vector<PairedFrame> frames)
      : PairedImages(std::move(frames), cameras.size()),
        cameras_(std::move(cameras)),
        forms_(std::move(forms)) {}

  fs::path file(std::size_t camera, std::size_t image) const {
    return cameras_[camera].folder / cameras_[camera].images[image].file;
  }

 private:
  GrayImage read_one(std::size_t camera, std::size_t image) const override {
    return read_image(file(camera, image), forms_[camera].size, forms_[camera].bits);
  }

  std::vector<CameraFiles> cameras_;
  std::vector<ImageForm> forms_;
};

std::string camera_name(std::size_t camera) { return fmt::format("cam{}", camera); }

// A table may name its files with folders: from the camera's folder, from one of those that it is
// in up to the recording's, or as they were on the computer that wrote it (the same name in the
// camera's folder). Returns the file's place as seen from the camera's folder; nothing if there is
// none.
std::optional<std::string> find_named(const CameraFiles& camera, const std::set<std::string>& there,
                                      std::string name) {
  if (there.contains(name)) return name;
  std::replace(name.begin(), name.end(), '\\', '/');
  const fs::path path(name);
  if (!path.has_parent_path()) return std::nullopt;
  const bool inside = path.is_relative() && std::find(path.begin(), path.end(), "..") == path.end();
  fs::path up = ".";
  for (int level = 0; inside && level <= kFoldersUp; ++level, up /= "..") {
    std::error_code ignored;
    if (fs::is_regular_file(camera.folder / up / path, ignored)) return (up / path).string();
  }
  const std::string plain = path.filename().string();
  return there.contains(plain) ? std::optional<std::string>(plain) : std::nullopt;
}

[[noreturn]] void fail_without_images(const CameraFiles& camera, std::size_t index,
                                      const std::vector<StampedFile>& listed) {
  throw InputError(fmt::format(
      "{}: none of the {} images of {} is there{}, expected {} files", camera.folder.string(),
      listed.size(), camera_name(index),
      listed.empty() ? ""
                     : fmt::format(", such as {}", (camera.folder / listed.front().file).string()),
      kImageKindNames));
}

// Sorts the images and keeps those whose files exist.
void tidy(CameraFiles& camera, std::size_t index, std::vector<std::string>& remarks) {
  bring_into_order(camera.images, "images of " + camera_name(index), remarks);
  const std::set<std::string> there = names_in(camera.folder);
  std::vector<StampedFile> listed = std::move(camera.images);
  camera.images.clear();
  for (const StampedFile& row : listed) {
    if (auto file = find_named(camera, there, row.file)) {
      camera.images.push_back({.time = row.time, .file = *std::move(file)});
    }
  }
  if (camera.images.empty()) fail_without_images(camera, index, listed);
  if (camera.images.size() < listed.size()) {
    remarks.push_back(fmt::format("{} of {} images of {} are listed, but are not in its folder",
                                  listed.size() - camera.images.size(), listed.size(),
                                  camera_name(index)));
  }
}

int used_bits(const CameraFiles& camera, const ImageSize& size, std::size_t index,
              std::vector<std::string>& remarks) {
  const auto range = deep_range(camera.images.size(), [&](std::size_t i) {
    const fs::path file = camera.folder / camera.images[i].file;
    return largest_deep_value(read_file(file), size, file.string());
  });
  if (!range) return kAllBits;
  remarks.push_back(deep_remark(*range, camera_name(index)));
  return range->bits;
}

}  // namespace

std::shared_ptr<const ImageSource> open_image_files(std::vector<CameraFiles> cameras,
                                                    const std::vector<Camera>& rig, Time tolerance,
                                                    std::vector<std::string>& remarks) {
  std::vector<ImageForm> forms;
  std::vector<std::vector<Time>> stamps(cameras.size());
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    tidy(cameras[c], c, remarks);
    const ImageSize size{.width = rig[c].width, .height = rig[c].height};
    forms.push_back({.size = size, .bits = used_bits(cameras[c], size, c, remarks)});
    for (const StampedFile& image : cameras[c].images) stamps[c].push_back(image.time);
  }
  std::vector<PairedFrame> frames = pair_images(stamps, are_finders(rig), tolerance, remarks);
  return std::make_shared<ImageFiles>(std::move(cameras), std::move(forms), std::move(frames));
}

fs::path image_file(const ImageSource& images, std::size_t i, std::size_t camera) {
  const auto* files = dynamic_cast<const ImageFiles*>(&images);
  const auto image = files ? files->member(i, camera) : std::nullopt;
  return image ? files->file(camera, *image) : fs::path();
}

}  // namespace chasles
