#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <chasles/loop/landmark_map.hpp>

namespace chasles {

/// A map's file that several runs may extend at the same time, in several processes.
class SharedMap {
 public:
  /// Reads it. Throws as read_map().
  explicit SharedMap(std::filesystem::path file);

  const std::filesystem::path& file() const { return file_; }
  const std::shared_ptr<const LandmarkMap>& map() const { return map_; }

  struct Saved {
    std::size_t landmarks = 0, bytes = 0;
    int others = 0;  ///< sessions that other runs added meanwhile
  };
  /// Replaces the file by what a run in the map left (Estimator::landmark_map()). A run may save
  /// more than once. What other runs have added since the map was read is merged in (merge_maps()):
  /// the result is the same bytes, whichever run ends first. Where the file is no longer there, it
  /// is made. Where it is another map now that cannot be merged, this map is saved beside it, and
  /// InputError has the reason and the name. Throws UsageError where nothing can be written.
  Saved save(const LandmarkMap& extended);

 private:
  Saved merged_with(const std::string& now, const std::filesystem::path& target) const;

  std::filesystem::path file_;
  std::string bytes_;  ///< as it was read
  std::shared_ptr<const LandmarkMap> map_;
  std::optional<LandmarkMap> own_, own_before_;  ///< of this run, as they are in the file
};

}  // namespace chasles
