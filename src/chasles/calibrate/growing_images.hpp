#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <unordered_set>
#include <vector>

namespace chasles {

/// What distinguishes a file from the same file after it was written on.
struct FileState {
  std::uintmax_t size = 0;
  std::filesystem::file_time_type written = {};

  bool operator==(const FileState&) const = default;
  /// None where the file is not there.
  static std::optional<FileState> of(const std::filesystem::path& file);
};

/// The images of the cameras of a folder that another program is still writing
/// (target_image_folders()). Images with equal names are of one instant.
class GrowingImages {
 public:
  explicit GrowingImages(std::filesystem::path folder) : folder_(std::move(folder)) {}

  struct Shot {
    std::string name;                          ///< without ending
    std::vector<std::filesystem::path> files;  ///< of each camera; empty: it has none
    std::vector<FileState> states;             ///< of the files, when they were whole
  };

  /// Finds new files. The folder need not be there yet.
  void poll();
  /// The newest shot that was not taken, so that whoever is slow sees what is recorded now: all its
  /// files are there and did not grow between the last two polls. Where a newer shot is whole, one
  /// may lack the images of some cameras. None: there is none.
  std::optional<Shot> take();
  /// For a shot that was taken and has a file that is not whole: it comes again when one of its
  /// files has changed.
  void put_back(const Shot& shot);

  std::size_t cameras() const { return cameras_; }  ///< with images until the last poll
  const std::set<std::string>& names() const { return names_; }  ///< of all shots
  std::size_t waiting() const { return waiting_.size(); }        ///< shots that were not taken

 private:
  struct File {
    std::filesystem::path path;
    FileState state = {};
    bool whole = false;  ///< it did not grow between two polls
  };
  struct Entry {
    std::map<std::size_t, File> files = {};  ///< by camera
    std::size_t place = 0;                   ///< in the order of arrival
    bool damaged = false;                    ///< until a file changes
  };

  void find_new(std::size_t camera, const std::filesystem::path& images);
  void check(Entry& entry);
  bool are_whole(const Entry& entry) const;

  std::filesystem::path folder_;
  std::size_t cameras_ = 0, arrived_ = 0, newest_whole_ = 0;
  std::vector<std::unordered_set<std::string>> known_;  ///< of each camera: names of files
  std::set<std::string> names_;
  std::map<std::string, Entry> waiting_;      ///< by name
  std::map<std::size_t, std::string> order_;  ///< their names, by their places
};

}  // namespace chasles
