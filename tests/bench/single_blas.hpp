#pragma once

#include <algorithm>
#include <cblas.h>
#include <type_traits>

#include <Eigen/Core>

extern "C" {
void spotrf_(const char* uplo, const int* n, float* a, const int* lda, int* info);
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
}

// chasles/filter/dense.hpp in either precision, as far as square_root_bench.cpp needs it.
namespace chasles::bench {

template <typename S>
using MatrixOf = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;
template <typename S>
using VectorOf = Eigen::Matrix<S, Eigen::Dynamic, 1>;
template <typename S>
using BlockOf = Eigen::Ref<MatrixOf<S>, 0, Eigen::OuterStride<>>;
template <typename S>
using ConstBlockOf = Eigen::Ref<const MatrixOf<S>, 0, Eigen::OuterStride<>>;

inline int as_int(Eigen::Index i) { return static_cast<int>(i); }

/// C <- C + alpha A B.
template <typename S>
void add_product(S alpha, const ConstBlockOf<S>& A, const ConstBlockOf<S>& B, BlockOf<S> C) {
  if (C.size() == 0 || A.cols() == 0) return;
  const auto call = [&](auto gemm) {
    gemm(CblasColMajor, CblasNoTrans, CblasNoTrans, as_int(A.rows()), as_int(B.cols()),
         as_int(A.cols()), alpha, A.data(), as_int(A.outerStride()), B.data(),
         as_int(B.outerStride()), S(1), C.data(), as_int(C.outerStride()));
  };
  if constexpr (std::is_same_v<S, float>) {
    call(cblas_sgemm);
  } else {
    call(cblas_dgemm);
  }
}

template <typename S>
MatrixOf<S> product(const ConstBlockOf<S>& A, const ConstBlockOf<S>& B) {
  MatrixOf<S> C = MatrixOf<S>::Zero(A.rows(), B.cols());
  add_product<S>(1, A, B, C);
  return C;
}

/// The lower triangle of C <- C + alpha A A^T.
template <typename S>
void add_square_lower(S alpha, const ConstBlockOf<S>& A, BlockOf<S> C) {
  if (A.size() == 0) return;
  const auto call = [&](auto syrk) {
    syrk(CblasColMajor, CblasLower, CblasNoTrans, as_int(C.rows()), as_int(A.cols()), alpha,
         A.data(), as_int(A.outerStride()), S(1), C.data(), as_int(C.outerStride()));
  };
  if constexpr (std::is_same_v<S, float>) {
    call(cblas_ssyrk);
  } else {
    call(cblas_dsyrk);
  }
}

/// X <- L^-1 X, or X <- X L^-T.
template <typename S>
void solve_lower(const ConstBlockOf<S>& L, BlockOf<S> X, bool from_right = false) {
  if (X.size() == 0) return;
  const auto call = [&](auto trsm) {
    trsm(CblasColMajor, from_right ? CblasRight : CblasLeft, CblasLower,
         from_right ? CblasTrans : CblasNoTrans, CblasNonUnit, as_int(X.rows()), as_int(X.cols()),
         S(1), L.data(), as_int(L.outerStride()), X.data(), as_int(X.outerStride()));
  };
  if constexpr (std::is_same_v<S, float>) {
    call(cblas_strsm);
  } else {
    call(cblas_dtrsm);
  }
}

/// A = L L^T, L in the lower triangle of A; false if A is not positive definite.
template <typename S>
bool cholesky(BlockOf<S> A) {
  const int n = as_int(A.rows());
  const int stride = as_int(A.outerStride());
  int info = 0;
  if constexpr (std::is_same_v<S, float>) {
    spotrf_("L", &n, A.data(), &stride, &info);
  } else {
    dpotrf_("L", &n, A.data(), &stride, &info);
  }
  return info == 0 && A.diagonal().allFinite();
}

/// The upper triangle of P <- the lower one.
template <typename S>
void mirror_lower(BlockOf<S> P) {
  constexpr Eigen::Index kTile = 32;
  const Eigen::Index n = P.rows();
  for (Eigen::Index j = 0; j < n; j += kTile) {
    const Eigen::Index b = std::min(kTile, n - j);
    P.block(j, j, b, b).template triangularView<Eigen::StrictlyUpper>() =
        P.block(j, j, b, b).transpose();
    for (Eigen::Index i = j + kTile; i < n; i += kTile) {
      const Eigen::Index h = std::min(kTile, n - i);
      P.block(j, i, b, h) = P.block(i, j, h, b).transpose();
    }
  }
}

}  // namespace chasles::bench
