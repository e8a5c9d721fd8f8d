#pragma once

#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <chasles/filter/scratch.hpp>

/// The filter's expensive dense operations, on OpenBLAS. OpenBLAS selects its kernels for the
/// processor at run time, so that a generic x86-64 build uses AVX where available.
namespace chasles::dense {

using Block = Eigen::Ref<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
using ConstBlock = Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

/// Restricts BLAS to one thread in this process, so that results do not depend on the machine's
/// load. Selects better kernels where OpenBLAS misjudges the processor. The environment variable
/// OPENBLAS_CORETYPE takes precedence. Only the first call has an effect. Filters, windows and
/// batch estimation call it themselves, so that a program and the command give identical results.
/// Throws std::bad_alloc where there is no memory for OpenBLAS's work buffer, 128 MiB of addresses;
/// the functions below throw it at their first use where prepare() was not called.
void prepare();

/// OpenBLAS's name for the kernels in use.
std::string_view kernels();

/// The kernels to request instead of those that OpenBLAS chose on an x86-64 processor with or
/// without AVX2 (and FMA) and AVX-512; empty if its choice is right. OpenBLAS before 0.3.25 chooses
/// the kernels of 2004 for an Intel processor with an unknown model number
/// (https://github.com/OpenMathLib/OpenBLAS/pull/4268), and 0.3.21 those of AVX2 for AMD processors
/// with AVX-512.
std::string_view better_kernels(std::string_view chosen, bool avx2, bool avx512);

/// S = L L^T, L in the lower triangle of S; false if S is not positive definite, or not finite. The
/// upper triangle is neither read nor written.
bool cholesky(Block S);

/// S = Q^T L L^T Q for a positive semidefinite S of which the lower triangle is read: L (n x rank)
/// in that triangle, order[k] the row of S that is row k of L. Returns the numerical rank.
Eigen::Index pivoted_cholesky(Block S, std::vector<int>& order, Scratch& workspace);

/// X <- L^-1 X.
void solve_lower(const ConstBlock& L, Block X);

/// X <- X L^-T.
void solve_lower_from_right(const ConstBlock& L, Block X);

/// The lower triangle of S <- A^T A.
void square_lower(const ConstBlock& A, Block S);

/// The lower triangle of P <- P - W W^T.
void downdate_lower(const ConstBlock& W, Block P);

/// The lower triangle of P <- P + A B, for a symmetric A B; the upper one is overwritten.
void add_product_lower(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, Block P);

/// y <- y + P x, from the lower triangle of P.
void add_symmetric_product(const ConstBlock& P, const Eigen::Ref<const Eigen::VectorXd>& x,
                           Eigen::Ref<Eigen::VectorXd> y);

/// P B for the symmetric matrix whose lower triangle is P's.
Eigen::MatrixXd symmetric_product(const ConstBlock& P, const Eigen::MatrixXd& B);

/// Rows first … first + count of the symmetric matrix whose lower triangle is P's: count x n.
Eigen::MatrixXd symmetric_rows(const ConstBlock& P, Eigen::Index first, Eigen::Index count);

/// The lower triangle of P <- P + B Z^T + Z B^T.
void symmetric_update_lower(const ConstBlock& B, const ConstBlock& Z, Block P);

/// A B, C <- A B (not in place), and C <- C + alpha A B.
Eigen::MatrixXd product(const ConstBlock& A, const ConstBlock& B);
void multiply(const ConstBlock& A, const ConstBlock& B, Block C);
void add_product(double alpha, const ConstBlock& A, const ConstBlock& B, Block C);

/// C <- C - A B^T.
void subtract_outer(const ConstBlock& A, const ConstBlock& B, Block C);

/// C <- C + A D^T, with three columns.
void add_turned(const ConstBlock& A, const Eigen::Matrix3d& D, Block C);

/// B <- A^T.
void transpose(const ConstBlock& A, Block B);

/// The upper triangle of P <- the lower one.
void mirror_lower(Block P);

}  // namespace chasles::dense
