#include <cerrno>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <string>
#include <system_error>
#include <unistd.h>

#include <chasles/filter/past/disk_matrix.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

std::size_t bytes_in(const MatrixXd& M) {
  return sizeof(double) * static_cast<std::size_t>(M.size());
}

int open_nameless(const std::filesystem::path& folder) {
#ifdef O_TMPFILE
  const int nameless = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (nameless >= 0) return nameless;
#endif
  std::string name = (folder / "chasles-XXXXXX").string();
  const int named = ::mkstemp(name.data());
  if (named < 0) return -1;
  ::unlink(name.c_str());
  ::fcntl(named, F_SETFD, FD_CLOEXEC);
  return named;
}

}  // namespace

DiskFile::DiskFile() : process_(::getpid()) {
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(error);
  if (!error) file_ = open_nameless(folder);
}

DiskFile::~DiskFile() {
  if (file_ >= 0) ::close(file_);
}

bool DiskFile::is_of_this_process() const { return process_ == ::getpid(); }

std::optional<std::int64_t> DiskFile::append(const MatrixXd& M) {
  if (file_ < 0) return std::nullopt;
  const char* const bytes = reinterpret_cast<const char*>(M.data());
  for (std::size_t done = 0; done < bytes_in(M);) {
    const ssize_t written =
        ::pwrite(file_, bytes + done, bytes_in(M) - done, size_ + static_cast<std::int64_t>(done));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return std::nullopt;
    done += static_cast<std::size_t>(written);
  }
  const std::int64_t at = size_;
  size_ += static_cast<std::int64_t>(bytes_in(M));
  return at;
}

void DiskFile::read(std::int64_t at, MatrixXd& M) const {
  char* const bytes = reinterpret_cast<char*>(M.data());
  for (std::size_t done = 0; done < bytes_in(M);) {
    const ssize_t got =
        ::pread(file_, bytes + done, bytes_in(M) - done, at + static_cast<std::int64_t>(done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) {
      throw std::system_error(got < 0 ? errno : EIO, std::generic_category(),
                              "the temporary file of past states");
    }
    done += static_cast<std::size_t>(got);
  }
}

MatrixXd DiskMatrix::read() const {
  MatrixXd M(rows_, cols_);
  file_->read(at_, M);
  return M;
}

std::optional<DiskMatrix> DiskMatrices::put(const MatrixXd& M) {
  const std::lock_guard lock(mutex_);
  if (!file_ || file_->size() >= bytes_of_file_ || !file_->is_of_this_process()) {
    file_ = std::make_shared<DiskFile>();
  }
  if (const auto at = file_->append(M)) return DiskMatrix(file_, *at, M.rows(), M.cols());
  file_.reset();  // there may be room later, or another folder
  return std::nullopt;
}

}  // namespace chasles
