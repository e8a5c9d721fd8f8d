#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace chasles {

/// Waits until the file or folder is on the disk. Throws UsageError.
void sync_to_disk(const std::filesystem::path& path);

/// Holds a folder against other processes of this machine that do the same, and waits for them. It
/// ends with the process. On a file system without locks, and where the folder cannot be read, it
/// has no effect.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock();

 private:
  int descriptor_;
};

/// A new file beside the one that it shall replace: FILE.part, or FILE.2.part where another process
/// writes that. It is locked, so that what a killed process left is known, and used again.
class PartFile {
 public:
  /// Creates it. Throws UsageError if that is not possible.
  explicit PartFile(std::filesystem::path file);
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;
  ~PartFile();  ///< removes it, unless it is in its place

  /// `.part` or `.2.part`: no other process has this one at the same file.
  const std::string& ending() const { return ending_; }
  std::filesystem::path path() const { return file_.string() + ending_; }
  /// Appends the bytes. Throws UsageError.
  void write(std::string_view bytes);
  /// Replaces the file. What was written must be on the disk. Throws UsageError.
  void move_over();

 private:
  std::filesystem::path file_;
  std::string ending_;
  int descriptor_ = -1;
};

/// Replaces a file as a whole: after a kill, a full disk or a power cut it is the old one or the
/// new one. The bytes are first written beside it, into a PartFile, so that several processes may
/// replace it at once; the last one counts. A link stays, and its file is replaced. What is no
/// regular file, such as /dev/stdout, is written directly (open_to_write). Throws UsageError.
void replace_file(const std::filesystem::path& file, std::string_view bytes);
/// The same of parts, as write_parts().
void replace_file(const std::filesystem::path& file,
                  const std::function<bool(std::string& part)>& next);

/// Several files of a folder that replace old ones. A fault while they are written leaves the old
/// ones. One of them marks a complete set: it is removed first and written last, so that readers
/// reject the folder in between. Several processes may write such sets at once; the last one
/// counts.
class FileSet {
 public:
  FileSet(std::filesystem::path folder, std::filesystem::path mark);
  FileSet(const FileSet&) = delete;
  FileSet& operator=(const FileSet&) = delete;
  ~FileSet();  ///< without commit(), removes the new files

  /// Where the new file of that name belongs: beside its place. Throws UsageError.
  std::filesystem::path place(const std::filesystem::path& name);
  /// Writes it. Throws UsageError.
  void add(const std::filesystem::path& name, std::string_view bytes);
  /// Without these bytes there is no such file after commit().
  void remove(const std::filesystem::path& name) { gone_.push_back(name); }
  /// Replaces the files. The mark must be among them. Throws UsageError.
  void commit();

 private:
  std::filesystem::path beside(const std::filesystem::path& name) const;

  std::filesystem::path folder_, mark_;
  std::optional<PartFile> of_mark_;
  std::vector<std::filesystem::path> names_, gone_;
};

}  // namespace chasles
