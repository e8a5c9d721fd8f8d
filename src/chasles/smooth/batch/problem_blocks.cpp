#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <ceres/cost_function.h>
#include <ceres/crs_matrix.h>

#include <chasles/smooth/batch/problem_blocks_detail.hpp>

namespace chasles::smooth_detail {
namespace {

ceres::Problem::Options problem_options() {
  ceres::Problem::Options options;
  options.enable_fast_removal = false;
  return options;
}

using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;
using SparseColumns = Eigen::SparseMatrix<double>;

// The lower triangle of J^T J, by columns. Eigen's sparse product forms and sorts both triangles,
// which takes as long as the factorisation.
SparseColumns lower_of_square(const Eigen::Map<const SparseRows>& J) {
  const SparseColumns by_columns = J;
  const int n = static_cast<int>(J.cols());
  std::vector<double> sum(static_cast<std::size_t>(n), 0.0);
  std::vector<int> seen(static_cast<std::size_t>(n), -1), rows;
  SparseColumns lower(n, n);
  lower.reserve(J.nonZeros() * 2);
  for (int j = 0; j < n; ++j) {
    rows.clear();
    for (SparseColumns::InnerIterator in_column(by_columns, j); in_column; ++in_column) {
      for (Eigen::Map<const SparseRows>::InnerIterator it(J, in_column.row()); it; ++it) {
        if (it.col() < j) continue;
        const auto i = static_cast<std::size_t>(it.col());
        if (std::exchange(seen[i], j) != j) rows.push_back(static_cast<int>(it.col()));
        sum[i] += in_column.value() * it.value();
      }
    }
    std::ranges::sort(rows);
    lower.startVec(j);
    for (const int row : rows) {
      lower.insertBack(row, j) = std::exchange(sum[static_cast<std::size_t>(row)], 0.0);
    }
  }
  lower.finalize();
  return lower;
}

}  // namespace

ProblemBlocks::ProblemBlocks(const BlockSizes& sizes, const std::string& chart)
    : sizes_(sizes),
      chart_(&error_chart(chart)),
      numbers_(stride() * sizes.keyframes + static_cast<std::size_t>(sizes.calibration.numbers()) +
               3 * sizes.points),
      problem_(std::make_unique<ceres::Problem>(problem_options())) {
  for (std::size_t k = 0; k < sizes_.keyframes; ++k) {
    write_pose({}, motion(k));  // the manifold's derivative is evaluated at once
    problem_->AddParameterBlock(motion(k), sizes_.motion(),
                                new ChartManifold(*chart_, sizes_.velocity));
    if (sizes_.additive > 0) problem_->AddParameterBlock(additive(k), sizes_.additive);
  }
  for (std::size_t i = 0; i < sizes_.calibration.all().size(); ++i) {
    const auto& block = sizes_.calibration.all()[i];
    if (block.is_pose) {
      write_pose({}, calibration(i));
      problem_->AddParameterBlock(calibration(i), block.numbers,
                                  new ChartManifold(kStandardChart, false));
    } else {
      problem_->AddParameterBlock(calibration(i), block.numbers);
    }
  }
  for (std::size_t i = 0; i < sizes_.points; ++i) problem_->AddParameterBlock(point(i), 3);
}

std::vector<double*> ProblemBlocks::keyframe(std::size_t k) {
  if (sizes_.additive == 0) return {motion(k)};
  return {motion(k), additive(k)};
}

std::vector<double*> ProblemBlocks::blocks() {
  std::vector<double*> all;
  for (std::size_t k = 0; k < sizes_.keyframes; ++k) {
    for (double* block : keyframe(k)) all.push_back(block);
  }
  for (std::size_t i = 0; i < sizes_.calibration.all().size(); ++i) all.push_back(calibration(i));
  for (std::size_t i = 0; i < sizes_.points; ++i) all.push_back(point(i));
  return all;
}

void ProblemBlocks::add_view(ceres::CostFunction* cost, ceres::LossFunction* loss,
                             const std::vector<double*>& of) {
  problem_->AddResidualBlock(cost, loss, of);
  views_.push_back({.cost = cost, .blocks = {of.begin(), of.end()}});
}

Eigen::VectorXd ProblemBlocks::whitened_residual(std::size_t view) const {
  const auto& [cost, blocks] = views_[view];
  Eigen::VectorXd residual(cost->num_residuals());
  cost->Evaluate(blocks.data(), residual.data(), nullptr);
  return residual;
}

std::vector<Eigen::VectorXd> ProblemBlocks::whitened_residuals() const {
  std::vector<Eigen::VectorXd> all;
  all.reserve(views_.size());
  for (std::size_t i = 0; i < views_.size(); ++i) all.push_back(whitened_residual(i));
  return all;
}

std::vector<double> ProblemBlocks::whitened_norms() const {
  std::vector<double> all;
  all.reserve(views_.size());
  for (std::size_t i = 0; i < views_.size(); ++i) all.push_back(whitened_residual(i).norm());
  return all;
}

std::vector<int> range(int first, int count) {
  std::vector<int> rows(static_cast<std::size_t>(count));
  std::iota(rows.begin(), rows.end(), first);
  return rows;
}

double loss_width_of(const BatchSettings& settings) {
  return settings.loss_width.value_or(kLossWidth);
}

ceres::LossFunction* loss_of(const BatchSettings& settings) {
  return loss_of(settings, loss_width_of(settings));
}

ceres::LossFunction* loss_of(const BatchSettings& settings, double width) {
  if (settings.loss == BatchLoss::kNone) return nullptr;
  if (settings.loss == BatchLoss::kHuber) return new ceres::HuberLoss(width);
  return new ceres::CauchyLoss(width);
}

NormalEquations normal_equations(ProblemBlocks& problem) {
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = problem.blocks();
  options.apply_loss_function = true;
  options.num_threads = 1;
  ceres::CRSMatrix crs;
  std::vector<double> gradient;
  problem.ceres().Evaluate(options, nullptr, nullptr, &gradient, &crs);
  const Eigen::Map<const SparseRows> J(crs.num_rows, crs.num_cols,
                                       static_cast<Eigen::Index>(crs.values.size()),
                                       crs.rows.data(), crs.cols.data(), crs.values.data());
  return {.lower = lower_of_square(J),
          .gradient = Eigen::Map<const Eigen::VectorXd>(gradient.data(), std::ssize(gradient))};
}

}  // namespace chasles::smooth_detail
