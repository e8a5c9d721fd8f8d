#include <csignal>
#include <unistd.h>
#include <vector>

#include <sys/resource.h>
#include <sys/wait.h>

#include <chasles/filter/past/disk_matrix.hpp>
#include <chasles/filter/past/temporary_folder_testing.hpp>
#include <chasles/filter/random_ekf_testing.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;

std::vector<MatrixXd> some_matrices() {
  test::Random random(4);
  return {test::random_matrix(random, 3, 7), test::random_matrix(random, 0, 7),
          test::random_matrix(random, 40, 11), test::random_matrix(random, 1, 1)};
}

TEST(DiskMatrices, ReadsTheBytesThatWerePut) {
  for (const std::int64_t bytes_of_file : {std::int64_t{1}, DiskMatrices::kBytesOfFile}) {
    DiskMatrices disk(bytes_of_file);
    const std::vector<MatrixXd> matrices = some_matrices();
    std::vector<DiskMatrix> put;
    for (const MatrixXd& M : matrices) put.push_back(disk.put(M).value());
    for (std::size_t i = 0; i < matrices.size(); ++i) {
      const MatrixXd read = put[i].read();
      EXPECT_EQ(put[i].size(), matrices[i].size());
      ASSERT_EQ(read.rows(), matrices[i].rows());
      EXPECT_EQ(read, matrices[i]);
    }
  }
}

TEST(DiskMatrices, AMatrixOutlivesThem) {
  const MatrixXd M = some_matrices()[2];
  const DiskMatrix kept = DiskMatrices().put(M).value();
  const DiskMatrix copy = kept;
  EXPECT_EQ(copy.read(), M);
}

TEST(DiskMatrices, ThereIsNoneWithoutAFolder) {
  DiskMatrices disk;
  const MatrixXd M = some_matrices()[0];
  {
    const test::TemporaryFolder nowhere("/proc/sys");
    EXPECT_FALSE(disk.put(M));
  }
  EXPECT_EQ(disk.put(M).value().read(), M) << "it tries again";
}

TEST(DiskMatrices, ThereIsNoneOnAFullDisk) {
  ::signal(SIGXFSZ, SIG_IGN);
  struct rlimit before {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const std::vector<MatrixXd> matrices = some_matrices();
  DiskMatrices disk;
  const DiskMatrix first = disk.put(matrices[0]).value();
  struct rlimit full = before;
  full.rlim_cur = 200;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &full), 0);
  EXPECT_FALSE(disk.put(matrices[2]));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  ::signal(SIGXFSZ, SIG_DFL);
  EXPECT_EQ(first.read(), matrices[0]);
  EXPECT_EQ(disk.put(matrices[2]).value().read(), matrices[2]);
}

TEST(DiskMatrices, AForkedProcessDoesNotWriteOverThoseOfItsParent) {
  const std::vector<MatrixXd> matrices = some_matrices();
  DiskMatrices disk;
  const DiskMatrix first = disk.put(matrices[0]).value();
  const pid_t child = ::fork();
  if (child == 0) {
    const auto own = disk.put(MatrixXd(-matrices[2]));
    const bool right = own && own->read() == MatrixXd(-matrices[2]) && first.read() == matrices[0];
    ::_exit(right ? 0 : 1);
  }
  const DiskMatrix second = disk.put(matrices[2]).value();
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(second.read(), matrices[2]);
}

}  // namespace
}  // namespace chasles
