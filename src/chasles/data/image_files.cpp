#include <set>
#include <utility>

#include <fmt/format.h>

#include <chasles/data/image_decode.hpp>
#include <chasles/data/image_files.hpp>
#include <chasles/data/pair_images.hpp>
#include <chasles/data/parse.hpp>
#include <chasles/data/time_order.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

bool is_image(const fs::path& file) {
  const std::string ending = file.extension().string();
  return ending == ".png" || ending == ".jpg" || ending == ".jpeg" || ending == ".PNG" ||
         ending == ".JPG" || ending == ".JPEG";
}

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

class ImageFiles : public ImageSource {
 public:
  ImageFiles(std::vector<CameraFiles> cameras, std::vector<ImageSize> sizes,
             std::vector<PairedFrame> frames)
      : cameras_(std::move(cameras)), sizes_(std::move(sizes)), frames_(std::move(frames)) {}

  std::size_t size() const override { return frames_.size(); }
  Time time(std::size_t i) const override { return frames_[i].time; }
  ImageFrame read(std::size_t i) const override {
    ImageFrame frame{.time = frames_[i].time, .images = {}};
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      const auto& member = frames_[i].members[c];
      frame.images.push_back(
          member ? read_image(cameras_[c].folder / cameras_[c].images[*member].file, sizes_[c])
                 : GrayImage{});
    }
    return frame;
  }

 private:
  std::vector<CameraFiles> cameras_;
  std::vector<ImageSize> sizes_;
  std::vector<PairedFrame> frames_;
};

std::string camera_name(std::size_t camera) { return fmt::format("cam{}", camera); }

// Sorts the images and keeps those whose files exist.
void tidy(CameraFiles& camera, std::size_t index, std::vector<std::string>& remarks) {
  bring_into_order(camera.images, "images of " + camera_name(index), remarks);
  const std::set<std::string> there = names_in(camera.folder);
  const std::size_t listed = camera.images.size();
  std::erase_if(camera.images, [&](const StampedFile& row) { return !there.contains(row.file); });
  if (camera.images.empty()) {
    throw InputError(
        fmt::format("{}: none of the {} images of {} is there, expected PNG or JPEG "
                    "files",
                    camera.folder.string(), listed, camera_name(index)));
  }
  if (camera.images.size() < listed) {
    remarks.push_back(fmt::format("{} of {} images of {} are listed, but are not in its folder",
                                  listed - camera.images.size(), listed, camera_name(index)));
  }
}

}  // namespace

std::vector<StampedFile> files_named_by_time(const fs::path& folder) {
  std::vector<StampedFile> images;
  for (const std::string& name : names_in(folder)) {
    if (!is_image(name)) continue;
    const std::string where =
        fmt::format("{}: the name of an image without a times.csv", (folder / name).string());
    images.push_back(
        {.time = parse_nanoseconds(where, fs::path(name).stem().string()), .file = name});
  }
  return images;
}

std::shared_ptr<const ImageSource> open_image_files(std::vector<CameraFiles> cameras,
                                                    const std::vector<Camera>& rig, Time tolerance,
                                                    std::vector<std::string>& remarks) {
  std::vector<ImageSize> sizes;
  std::vector<std::vector<Time>> stamps(cameras.size());
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    tidy(cameras[c], c, remarks);
    sizes.push_back({.width = rig[c].width, .height = rig[c].height});
    for (const StampedFile& image : cameras[c].images) stamps[c].push_back(image.time);
  }
  std::vector<PairedFrame> frames = pair_images(stamps, tolerance, remarks);
  return std::make_shared<ImageFiles>(std::move(cameras), std::move(sizes), std::move(frames));
}

}  // namespace chasles
