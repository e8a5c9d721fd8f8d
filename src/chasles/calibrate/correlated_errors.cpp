#include <algorithm>
#include <numeric>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <chasles/calibrate/correlated_errors_detail.hpp>

namespace chasles::calibrate_detail {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kPieceSeconds = 1;
constexpr double kMoved = 0.1;     // of the diagonal of the corners
constexpr int kEnoughPieces = 10;  // to measure a scatter

bool any_has_moved(const Instant& from, const Instant& to) {
  bool has_common = false;
  for (const TargetView* a : from.views) {
    for (const TargetView* b : to.views) {
      if (a->camera != b->camera) continue;
      has_common = true;
      if (has_moved(*a, *b)) return true;
    }
  }
  return !has_common;
}

}  // namespace

bool has_moved(const TargetView& from, const TargetView& to) {
  Eigen::AlignedBox2d box;
  double sum = 0, common = 0;
  for (std::size_t i = 0, j = 0; i < from.ids.size() && j < to.ids.size();) {
    if (from.ids[i] != to.ids[j]) {
      ++(from.ids[i] < to.ids[j] ? i : j);
      continue;
    }
    box.extend(from.pixels[i]);
    sum += (to.pixels[j++] - from.pixels[i++]).norm();
    ++common;
  }
  return common == 0 || sum / common > kMoved * box.diagonal().norm();
}

std::vector<int> independent_pieces(const std::vector<Instant>& instants) {
  std::vector<int> pieces;
  std::size_t begin = 0;
  int piece = 0;
  for (std::size_t k = 0; k < instants.size(); ++k) {
    if (to_seconds(instants[k].time - instants[begin].time) >= kPieceSeconds &&
        any_has_moved(instants[begin], instants[k])) {
      begin = k;
      ++piece;
    }
    pieces.push_back(piece);
  }
  return pieces;
}

double correlation_factor(const MatrixXd& information, const MatrixXd& gradients,
                          std::span<const int> rows, std::span<const int> pieces) {
  const std::vector<int> kept(rows.begin(), rows.end());
  std::vector<int> other;
  for (int row = 0; row < information.rows(); ++row) {
    if (std::ranges::find(kept, row) == kept.end()) other.push_back(row);
  }
  MatrixXd of_kept = information(kept, kept), gradient = gradients(kept, Eigen::all);
  if (!other.empty()) {
    const MatrixXd by_other = information(other, other).ldlt().solve(information(other, kept));
    of_kept -= information(kept, other) * by_other;
    gradient -= by_other.transpose() * gradients(other, Eigen::all);
  }
  const int count = pieces.back() + 1;
  MatrixXd sums = MatrixXd::Zero(of_kept.rows(), count);
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    sums.col(pieces[k]) += gradient.col(static_cast<Eigen::Index>(k));
  }
  const double scatter =
      of_kept.ldlt().solve(sums * sums.transpose()).trace() / static_cast<double>(of_kept.rows());
  const double alike = count < kEnoughPieces ? static_cast<double>(pieces.size()) / count : 1;
  return std::max({1.0, scatter, alike});
}

}  // namespace chasles::calibrate_detail
