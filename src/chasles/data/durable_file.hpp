#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace chasles {

/// Waits until the file or folder is on the disk. Throws UsageError.
void sync_to_disk(const std::filesystem::path& path);

/// Replaces a file as a whole: after a kill, a full disk or a power cut it is the old one or the
/// new one. The bytes are first written beside it, into FILE.part. What is no regular file, such as
/// /dev/stdout, is written directly. Throws UsageError.
void replace_file(const std::filesystem::path& file, std::string_view bytes);

/// Several files of a folder that replace old ones. A fault while they are written leaves the old
/// ones. One of them marks a complete set: it is removed first and written last, so that readers
/// refuse the folder in between.
class FileSet {
 public:
  FileSet(std::filesystem::path folder, std::filesystem::path mark);
  FileSet(const FileSet&) = delete;
  FileSet& operator=(const FileSet&) = delete;
  ~FileSet();  ///< without commit(), removes the new files

  /// Where the new file of that name belongs: NAME.part.
  std::filesystem::path place(const std::filesystem::path& name);
  /// Writes it. Throws UsageError.
  void add(const std::filesystem::path& name, std::string_view bytes);
  /// Without these bytes there is no such file after commit().
  void remove(const std::filesystem::path& name) { gone_.push_back(name); }
  /// Replaces the files. The mark must be among them. Throws UsageError.
  void commit();

 private:
  std::filesystem::path folder_, mark_;
  std::vector<std::filesystem::path> names_, gone_;
};

}  // namespace chasles
