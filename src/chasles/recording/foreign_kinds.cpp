#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/bags/bag_paths.hpp>
#include <chasles/codec/folder_names.hpp>
#include <chasles/codec/foreign_files.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/foreign_kinds.hpp>
#include <chasles/recording/readers.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// The names in a folder, in order; hidden ones are left out.
struct Listing {
  fs::path folder;
  std::vector<std::string> files, folders;

  explicit Listing(const fs::path& path) : folder(path) {
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(path, ignored)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with('.')) continue;
      (entry.is_directory(ignored) ? folders : files).push_back(name);
    }
    std::ranges::sort(files);
    std::ranges::sort(folders);
  }
  bool file(std::string_view name) const { return std::ranges::find(files, name) != files.end(); }
  bool dir(std::string_view name) const {
    return std::ranges::find(folders, name) != folders.end();
  }
  // The files whose names end so, in small or capital letters.
  std::vector<std::string> ending(std::initializer_list<std::string_view> endings) const {
    std::vector<std::string> found;
    for (const std::string& name : files) {
      const std::string small = lower_case(name);
      const auto ends = [&](std::string_view ending) { return small.ends_with(ending); };
      if (std::ranges::any_of(endings, ends)) found.push_back(name);
    }
    return found;
  }
};

// The first names, and how many more there are.
std::string some_of(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 3;
  if (names.size() <= kMost) return fmt::format("{}", fmt::join(names, ", "));
  return fmt::format("{}, {}, {} and {} more", names[0], names[1], names[2], names.size() - kMost);
}

bool is_recording_folder(const fs::path& folder) {
  std::error_code ignored;
  return is_euroc_asl_folder(folder) || is_kitti_raw_folder(folder) ||
         is_kitti_odometry_folder(folder) || is_image_folder(folder) || is_bag_folder(folder) ||
         is_video_folder(folder) || fs::exists(folder / "calibration.yaml", ignored);
}

using Verdict = std::optional<std::string>;

Verdict run_of_ours(const Listing& l) {
  if (!l.file("states.csv") || !l.file("summary.json")) return std::nullopt;
  return "looks like a run folder of chasles run -o: give the recording; chasles report and "
         "chasles "
         "evaluate read runs";
}

Verdict part_of_euroc(const Listing& l) {
  if (!l.file("data.csv") || !(l.file("sensor.yaml") || l.dir("data"))) return std::nullopt;
  return "looks like one sensor of an EuRoC recording: give the folder that holds mav0";
}

Verdict archives(const Listing& l) {
  const auto found = l.ending({".zip", ".tar", ".tar.gz", ".tgz", ".7z"});
  if (found.empty()) return std::nullopt;
  return fmt::format(
      "looks like a folder of archives ({}): unpack them, and give the folder that "
      "holds mav0 or images",
      some_of(found));
}

// Also two levels below: MH_01_easy/MH_01_easy/mav0.
Verdict above_recordings(const Listing& l) {
  std::vector<std::string> found;
  for (const std::string& name : l.folders) {
    if (is_recording_folder(l.folder / name)) {
      found.push_back(name);
      continue;
    }
    for (const std::string& below : Listing(l.folder / name).folders) {
      if (is_recording_folder(l.folder / name / below)) found.push_back(name + "/" + below);
    }
  }
  if (found.empty()) return std::nullopt;
  return fmt::format("looks like the folder above {}: give {} ({})",
                     found.size() == 1 ? "a recording" : "several recordings",
                     found.size() == 1 ? "that one" : "one of them", some_of(found));
}

Verdict tum_rgbd(const Listing& l) {
  const bool lists = l.file("rgb.txt") || (l.dir("rgb") && l.dir("depth"));
  const bool more = l.file("depth.txt") || l.dir("depth") || l.file("accelerometer.txt");
  if (!lists || !more) return std::nullopt;
  return "looks like a TUM RGB-D sequence: it has no gyroscope, which a run with images needs (its "
         "accelerometer.txt has accelerations alone)";
}

std::string begin_of_file(const fs::path& file) {
  std::array<char, 512> begin{};
  std::ifstream stream(file, std::ios::binary);
  stream.read(begin.data(), begin.size());
  return {begin.data(), static_cast<std::size_t>(stream.gcount())};
}

// A model of structure from motion, as text or binary; of its text an image's row begins with its
// number and a quaternion.
Verdict colmap_model(const Listing& l) {
  for (const std::string_view ending : {".txt", ".bin"}) {
    const auto has = [&](const char* name) { return l.file(std::string(name).append(ending)); };
    const int parts = int(has("cameras")) + int(has("images")) + int(has("points3D"));
    if (parts < 2) continue;
    return fmt::format(
        "looks like a model of COLMAP (cameras{0}, images{0}, points3D{0}), which has poses and "
        "points but neither times nor an IMU: give the recording that its images come from",
        ending);
  }
  if (l.dir("sparse")) return colmap_model(Listing(l.folder / "sparse" / "0"));
  for (const char* alone : {"images.txt", "points3D.txt", "cameras.txt"}) {
    const auto known_as =
        l.file(alone) ? foreign_file(alone, begin_of_file(l.folder / alone)) : Verdict();
    if (known_as && known_as->find("COLMAP") != std::string::npos)
      return "holds " + (alone + (", which " + *known_as));
  }
  return std::nullopt;
}

// Lists of images beside a folder of them, without the samples of an IMU.
Verdict listed_images(const Listing& l) {
  if (!l.file("left_images.txt") && !l.file("images.txt")) return std::nullopt;
  return "looks like a sequence of UZH-FPV without its imu.txt, which a run needs: a table with "
         "the "
         "columns timestamp,wx,wy,wz,ax,ay,az";
}

Verdict kitti_odometry_without_images(const Listing& l) {
  if (!l.file("calib.txt") || !l.file("times.txt")) return std::nullopt;
  return "looks like KITTI odometry without its images: image_0 and image_1 are expected here";
}

Verdict extracted_bag(const Listing& l) {
  const bool slashes = std::ranges::any_of(
      l.files, [](const std::string& name) { return name.find("_slash_") != std::string::npos; });
  if (!slashes && !l.dir("cam0")) return std::nullopt;
  return "looks like an extracted bag: a run needs the IMU's table beside the folders of the "
         "images "
         "(imu.csv or imu0.csv), and Kalibr's files or calibration.yaml";
}

// Whose order of cameras only the calibration knows.
Verdict folders_of_images(const Listing& l) {
  std::vector<std::string> found;
  for (const std::string& name : l.folders) {
    const Listing below(l.folder / name);
    if (!below.ending({".png", ".jpg", ".jpeg", ".pgm"}).empty()) found.push_back(name);
  }
  if (found.empty()) return std::nullopt;
  return fmt::format(
      "looks like folders of images ({}): name them images/cam0, images/cam1, ... in the order of "
      "the calibration, with imu.csv beside images (docs/your-recording.md)",
      some_of(found));
}

// One file of another program in it, such as a flight log beside a calibration.
Verdict foreign_file_within(const Listing& l) {
  constexpr std::size_t kMost = 100;
  const auto usual = l.ending({".yaml", ".yml", ".json", ".png", ".jpg", ".jpeg", ".pdf", ".ply",
                               ".pcd", ".xml", ".html", ".txt", ".csv"});
  for (std::size_t i = 0; i < std::min(kMost, l.files.size()); ++i) {
    const std::string& name = l.files[i];
    if (std::ranges::find(usual, name) != usual.end()) continue;
    const std::string bytes = begin_of_file(l.folder / name);
    const auto known_as = bytes.empty() ? Verdict() : foreign_file(name, bytes);
    if (known_as) return fmt::format("holds {}, which {}", name, *known_as);
  }
  return std::nullopt;
}

Verdict images_alone(const Listing& l) {
  const std::size_t count =
      l.ending({".png", ".jpg", ".jpeg", ".pgm", ".bmp", ".tif", ".tiff", ".webp"}).size();
  if (count == 0) return std::nullopt;
  return fmt::format(
      "looks like {} images alone: a run needs them in images/cam0, and imu.csv and "
      "a calibration beside images (docs/your-recording.md)",
      count);
}

Verdict nothing(const Listing& l) {
  if (!l.files.empty() || !l.folders.empty()) return std::nullopt;
  return "is empty";
}

// The first one that knows the folder counts.
constexpr std::array kForeignFolders{run_of_ours,
                                     part_of_euroc,
                                     archives,
                                     above_recordings,
                                     tum_rgbd,
                                     colmap_model,
                                     listed_images,
                                     kitti_odometry_without_images,
                                     extracted_bag,
                                     folders_of_images,
                                     foreign_file_within,
                                     images_alone,
                                     nothing};

}  // namespace

std::optional<std::string> foreign_folder(const fs::path& folder) {
  const Listing listing(folder);
  for (const auto& knows : kForeignFolders) {
    if (Verdict verdict = knows(listing)) return verdict;
  }
  return std::nullopt;
}

}  // namespace chasles
