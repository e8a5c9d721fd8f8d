#include "kinds.hpp"

#include <unistd.h>

namespace chasles::fuzz {

std::vector<Kind> kinds() {
  std::vector<Kind> all;
  for (auto* list : {velocity_kinds, inertial_kinds, image_folder_kinds, rig_kinds, bag_kinds,
                     video_kinds, single_file_kinds}) {
    for (const Kind& kind : list()) all.push_back(kind);
  }
  return all;
}

std::filesystem::path make_scratch() {
  namespace fs = std::filesystem;
  const fs::path memory = "/dev/shm";
  fs::path folder = (fs::exists(memory) ? memory : fs::temp_directory_path()) /
                    ("chasles_fuzz_" + std::to_string(getpid()));
  fs::create_directories(folder);
  return folder;
}

}  // namespace chasles::fuzz
