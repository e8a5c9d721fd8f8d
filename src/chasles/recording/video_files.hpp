#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace chasles {

/// A video, and where the files that belong to it are.
struct VideoPlace {
  std::filesystem::path video;
  std::filesystem::path folder;  ///< of the video
  bool is_alone = false;         ///< the folder has no other video
  bool by_folder = false;        ///< the folder was given

  /// `ENDING` behind the video's name without .mp4, in its folder: walk.mp4, "_mask.png".
  std::filesystem::path beside(const std::string& ending) const;
  /// The first of these files that exists. `own`: endings as of beside(); `shared`: names in the
  /// folder, which count where the video is alone.
  std::optional<std::filesystem::path> first_of(const std::vector<std::string>& own,
                                                const std::vector<std::string>& shared) const;
};

/// Whether a file begins as MP4 or QuickTime, and its name is none of another program's.
bool is_video_file(const std::filesystem::path& file, std::string_view first_bytes);

/// The videos in a folder by their names (.mp4, .mov), without hidden ones.
std::vector<std::filesystem::path> videos_in(const std::filesystem::path& folder);

/// The place of a video, or of the only one in a folder. Throws InputError for a folder with
/// several, with their names.
VideoPlace find_video(const std::filesystem::path& path);

/// The next chapter of a long recording of a GoPro, if it is beside: GX020001.MP4 after
/// GX010001.MP4.
std::optional<std::filesystem::path> next_chapter(const std::filesystem::path& video);

}  // namespace chasles
