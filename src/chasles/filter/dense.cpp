#include <algorithm>
#include <cblas.h>
#include <cstdlib>
#include <mutex>
#include <new>

#include <sys/mman.h>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/mirror_lower.hpp>

extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dpstrf_(const char* uplo, const int* n, double* a, const int* lda, int* pivots, int* rank,
             const double* tolerance, double* work, int* info);
void openblas_set_num_threads(int threads);
char* openblas_get_corename();
// OpenBLAS's selection of kernels; only in builds with run-time selection.
[[gnu::weak]] void gotoblas_dynamic_init();
[[gnu::weak]] void gotoblas_dynamic_quit();
}

namespace chasles::dense {
namespace {

int as_int(Eigen::Index i) { return static_cast<int>(i); }

// OpenBLAS takes a work buffer at the first use and keeps it. Where the system gives it none, it
// asks again for ever. So the same memory is asked for first, and then the buffer is taken at once.
void take_buffer() {
  constexpr std::size_t kBuffer = std::size_t{32}
                                  << 22;               // BUFFER_SIZE in its common.h, all of 64 bit
  constexpr std::size_t kMore = std::size_t{1} << 20;  // its alignment, and what malloc adds
  void* const room = ::mmap(nullptr, kBuffer + kMore, PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room == MAP_FAILED) throw std::bad_alloc();
  ::munmap(room, kBuffer + kMore);
  const int one = 1;
  double number = 1;
  int info = 0;
  dpotrf_("L", &one, &number, &one, &info);
}

// The serial OpenBLAS has one work buffer for all threads of a process. Filters in several threads
// gave wrong numbers without a word.
[[nodiscard]] std::unique_lock<std::mutex> alone() {
  static std::mutex mutex;
  static bool has_buffer = false;
  std::unique_lock turn(mutex);
  if (!has_buffer) {
    take_buffer();
    has_buffer = true;
  }
  return turn;
}

// C <- alpha A B + beta C; with beta = 0 C is not read.
void multiply(double alpha, const ConstBlock& A, const ConstBlock& B, double beta, Block C) {
  const auto turn = alone();
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, as_int(A.rows()), as_int(B.cols()),
              as_int(A.cols()), alpha, A.data(), as_int(A.outerStride()), B.data(),
              as_int(B.outerStride()), beta, C.data(), as_int(C.outerStride()));
}

#if defined(__x86_64__)
bool supports_avx2() { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }
bool supports_avx512() {
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}
#else
bool supports_avx2() { return false; }
bool supports_avx512() { return false; }
#endif

void prepare_once() {
  openblas_set_num_threads(1);
  if (!gotoblas_dynamic_init || !gotoblas_dynamic_quit) return;
  if (std::getenv("OPENBLAS_CORETYPE")) return;  // set by the user
  const std::string_view better = better_kernels(kernels(), supports_avx2(), supports_avx512());
  if (better.empty()) return;
  setenv("OPENBLAS_CORETYPE", better.data(), 1);
  gotoblas_dynamic_quit();
  gotoblas_dynamic_init();
  unsetenv("OPENBLAS_CORETYPE");
}

}  // namespace

void prepare() {
  static std::once_flag done;
  std::call_once(done, prepare_once);
  const auto turn = alone();  // with its buffer
}

std::string_view kernels() { return openblas_get_corename(); }

std::string_view better_kernels(std::string_view chosen, bool avx2, bool avx512) {
  const bool for_old = chosen == "Prescott", for_avx2 = chosen == "Haswell" || chosen == "Zen";
  if (avx512 && (for_old || for_avx2)) return "SkylakeX";
  return avx2 && for_old ? "Haswell" : "";
}

bool cholesky(Block S) {
  const int n = as_int(S.rows());
  const int stride = as_int(S.outerStride());
  int info = 0;
  const auto turn = alone();
  if (n > 0) dpotrf_("L", &n, S.data(), &stride, &info);
  // OpenBLAS reports no error for a NaN, but propagates it to the diagonal.
  return info == 0 && S.diagonal().allFinite();
}

Eigen::Index pivoted_cholesky(Block S, std::vector<int>& order, Scratch& workspace) {
  const int n = as_int(S.rows());
  const int stride = as_int(S.outerStride());
  order.resize(static_cast<std::size_t>(n));
  int rank = 0, info = 0;
  const double n_eps_times_the_largest = -1;
  if (n > 0) {
    auto work = workspace.take<Eigen::VectorXd>(2 * n);
    const auto turn = alone();
    dpstrf_("L", &n, S.data(), &stride, order.data(), &rank, &n_eps_times_the_largest, work.data(),
            &info);
  }
  for (int& row : order) --row;  // Fortran counts from one
  return rank;
}

void solve_lower(const ConstBlock& L, Block X) {
  if (X.size() == 0) return;
  const auto turn = alone();
  cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, as_int(X.rows()),
              as_int(X.cols()), 1.0, L.data(), as_int(L.outerStride()), X.data(),
              as_int(X.outerStride()));
}

void solve_lower_from_right(const ConstBlock& L, Block X) {
  if (X.size() == 0) return;
  const auto turn = alone();
  cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, as_int(X.rows()),
              as_int(X.cols()), 1.0, L.data(), as_int(L.outerStride()), X.data(),
              as_int(X.outerStride()));
}

void square_lower(const ConstBlock& A, Block S) {
  if (S.size() == 0) return;
  const auto turn = alone();
  cblas_dsyrk(CblasColMajor, CblasLower, CblasTrans, as_int(S.rows()), as_int(A.rows()), 1.0,
              A.data(), as_int(A.outerStride()), 0.0, S.data(), as_int(S.outerStride()));
}

void downdate_lower(const ConstBlock& W, Block P) {
  if (W.size() == 0) return;
  const auto turn = alone();
  cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, as_int(P.rows()), as_int(W.cols()), -1.0,
              W.data(), as_int(W.outerStride()), 1.0, P.data(), as_int(P.outerStride()));
}

void add_product_lower(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, Block P) {
  constexpr Eigen::Index kPanel = 64;
  const Eigen::Index n = P.rows();
  for (Eigen::Index j = 0; j < n; j += kPanel) {
    const Eigen::Index width = std::min(kPanel, n - j);
    add_product(1, A.bottomRows(n - j), B.middleCols(j, width), P.block(j, j, n - j, width));
  }
}

void add_symmetric_product(const ConstBlock& P, const Eigen::Ref<const Eigen::VectorXd>& x,
                           Eigen::Ref<Eigen::VectorXd> y) {
  if (P.size() == 0) return;
  const auto turn = alone();
  cblas_dsymv(CblasColMajor, CblasLower, as_int(P.rows()), 1.0, P.data(), as_int(P.outerStride()),
              x.data(), 1, 1.0, y.data(), 1);
}

Eigen::MatrixXd symmetric_rows(const ConstBlock& P, Eigen::Index first, Eigen::Index count) {
  const Eigen::Index after = P.rows() - first - count;
  Eigen::MatrixXd rows(count, P.rows());
  rows.leftCols(first) = P.block(first, 0, count, first);
  rows.middleCols(first, count) =
      P.block(first, first, count, count).template selfadjointView<Eigen::Lower>();
  rows.rightCols(after) = P.block(first + count, first, after, count).transpose();
  return rows;
}

Eigen::MatrixXd symmetric_product(const ConstBlock& P, const Eigen::MatrixXd& B) {
  Eigen::MatrixXd C(P.rows(), B.cols());
  if (C.size() == 0) return C;
  const auto turn = alone();
  cblas_dsymm(CblasColMajor, CblasLeft, CblasLower, as_int(P.rows()), as_int(B.cols()), 1.0,
              P.data(), as_int(P.outerStride()), B.data(), as_int(B.outerStride()), 0.0, C.data(),
              as_int(C.outerStride()));
  return C;
}

void symmetric_update_lower(const ConstBlock& B, const ConstBlock& Z, Block P) {
  if (B.size() == 0) return;
  const auto turn = alone();
  cblas_dsyr2k(CblasColMajor, CblasLower, CblasNoTrans, as_int(P.rows()), as_int(B.cols()), 1.0,
               B.data(), as_int(B.outerStride()), Z.data(), as_int(Z.outerStride()), 1.0, P.data(),
               as_int(P.outerStride()));
}

Eigen::MatrixXd product(const ConstBlock& A, const ConstBlock& B) {
  Eigen::MatrixXd C(A.rows(), B.cols());
  multiply(A, B, C);
  return C;
}

void multiply(const ConstBlock& A, const ConstBlock& B, Block C) {
  if (A.cols() == 0) C.setZero();
  if (A.cols() > 0 && C.size() > 0) multiply(1, A, B, 0, C);
}

void add_product(double alpha, const ConstBlock& A, const ConstBlock& B, Block C) {
  if (C.size() > 0 && A.cols() > 0) multiply(alpha, A, B, 1, C);
}

void subtract_outer(const ConstBlock& A, const ConstBlock& B, Block C) {
  if (C.size() == 0 || A.cols() == 0) return;
  const auto turn = alone();
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, as_int(C.rows()), as_int(C.cols()),
              as_int(A.cols()), -1.0, A.data(), as_int(A.outerStride()), B.data(),
              as_int(B.outerStride()), 1.0, C.data(), as_int(C.outerStride()));
}

void add_turned(const ConstBlock& A, const Eigen::Matrix3d& D, Block C) {
  for (int j = 0; j < 3; ++j) {
    C.col(j) += D(j, 0) * A.col(0) + D(j, 1) * A.col(1) + D(j, 2) * A.col(2);
  }
}

void transpose(const ConstBlock& A, Block B) {
  constexpr Eigen::Index kColumns = 8;  // numbers of a cache line
  for (Eigen::Index j = 0; j < A.cols(); j += kColumns) {
    const Eigen::Index width = std::min(kColumns, A.cols() - j);
    B.middleRows(j, width) = A.middleCols(j, width).transpose();
  }
}

void mirror_lower(Block P) { mirror_lower_of(P); }

}  // namespace chasles::dense
