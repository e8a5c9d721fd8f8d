#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>

#include <Eigen/Core>

namespace chasles {

/// A temporary file without a name, in the folder of temporary files ($TMPDIR, else /tmp): nothing
/// is left of a program that ends. What is written into it stays as it is. It is read and written
/// by calls, because pages of a mapped file count as memory of the process.
class DiskFile {
 public:
  DiskFile();
  ~DiskFile();
  DiskFile(const DiskFile&) = delete;
  DiskFile& operator=(const DiskFile&) = delete;

  /// Writes the matrix at the end, and returns where that is; none where it cannot be written.
  std::optional<std::int64_t> append(const Eigen::MatrixXd& M);
  /// Throws std::system_error where what was written cannot be read.
  void read(std::int64_t at, Eigen::MatrixXd& M) const;

  std::int64_t size() const { return size_; }
  /// False in a process that was forked since: its parent writes at the same place.
  bool is_of_this_process() const;

 private:
  int file_ = -1;
  int process_;
  std::int64_t size_ = 0;
};

/// A matrix in a file. Copies share it.
class DiskMatrix {
 public:
  DiskMatrix(std::shared_ptr<const DiskFile> file, std::int64_t at, Eigen::Index rows,
             Eigen::Index cols)
      : file_(std::move(file)), at_(at), rows_(rows), cols_(cols) {}

  Eigen::Index size() const { return rows_ * cols_; }
  Eigen::MatrixXd read() const;

 private:
  std::shared_ptr<const DiskFile> file_;
  std::int64_t at_;
  Eigen::Index rows_, cols_;
};

/// Puts matrices on disk. A full file is followed by another one, so that the space of old matrices
/// is free when nobody has them any more. Several threads may use it.
class DiskMatrices {
 public:
  static constexpr std::int64_t kBytesOfFile = 256 << 20;

  explicit DiskMatrices(std::int64_t bytes_of_file = kBytesOfFile)
      : bytes_of_file_(bytes_of_file) {}

  /// None where there is no room for it, or no folder of temporary files.
  std::optional<DiskMatrix> put(const Eigen::MatrixXd& M);

 private:
  std::mutex mutex_;
  std::int64_t bytes_of_file_;
  std::shared_ptr<DiskFile> file_;
};

}  // namespace chasles
