#include <Eigen/Cholesky>

#include <chasles/calibrate/chain_equations.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

void add_columns(MatrixXd& matrix, std::span<const int> columns, const MatrixXd& part) {
  for (std::size_t j = 0; j < columns.size(); ++j) {
    matrix.col(columns[j]) += part.col(static_cast<Eigen::Index>(j));
  }
}

void add_rows(VectorXd& vector, std::span<const int> rows, const VectorXd& part) {
  for (std::size_t j = 0; j < rows.size(); ++j) {
    vector[rows[j]] += part[static_cast<Eigen::Index>(j)];
  }
}

// Whether each unknown is determined: a pivot is what its information is when those before it are
// unknown, too. Independent of units.
bool determines(const Eigen::LLT<MatrixXd>& factor, const VectorXd& information) {
  constexpr double kLeast = 1e-12;
  if (factor.info() != Eigen::Success) return false;
  const VectorXd pivots = factor.matrixLLT().diagonal().array().square();
  return (pivots.array() > kLeast * information.array()).all();
}

}  // namespace

// The chain is eliminated from its first block on: each leaves a term on the next one and on the
// border.
struct ChainEquations::Eliminated {
  std::vector<Eigen::LLT<MatrixXd>> factors;
  std::vector<MatrixXd> by_border;  // of each block, with what those before it left
  std::vector<VectorXd> gradient;
  MatrixXd border;
  VectorXd border_gradient;
};

ChainEquations::ChainEquations(std::size_t blocks, Eigen::Index size, Eigen::Index border)
    : size_(size),
      border_(border),
      diagonal_(blocks, MatrixXd::Zero(size, size)),
      next_(blocks),
      by_border_(blocks, MatrixXd::Zero(size, border)),
      gradient_(blocks, VectorXd::Zero(size)),
      own_border_(blocks, VectorXd::Zero(border)),
      border_matrix_(MatrixXd::Zero(border, border)),
      border_gradient_(VectorXd::Zero(border)) {}

void ChainEquations::add(std::size_t block, const MatrixXd& by_block, const MatrixXd& by_border,
                         std::span<const int> columns, const VectorXd& r) {
  diagonal_[block].noalias() += by_block.transpose() * by_block;
  gradient_[block].noalias() += by_block.transpose() * r;
  add_columns(by_border_[block], columns, by_block.transpose() * by_border);
  add_rows(own_border_[block], columns, by_border.transpose() * r);
  add_border(by_border, columns, r);
}

void ChainEquations::add_link(std::size_t block, const MatrixXd& by_block, const MatrixXd& by_next,
                              const MatrixXd& by_border, std::span<const int> columns,
                              const VectorXd& r) {
  add(block, by_block, by_border, columns, r);
  diagonal_[block + 1].noalias() += by_next.transpose() * by_next;
  gradient_[block + 1].noalias() += by_next.transpose() * r;
  add_columns(by_border_[block + 1], columns, by_next.transpose() * by_border);
  if (next_[block].size() == 0) next_[block] = MatrixXd::Zero(size_, size_);
  next_[block].noalias() += by_block.transpose() * by_next;
}

void ChainEquations::add_border(const MatrixXd& by_border, std::span<const int> columns,
                                const VectorXd& r) {
  const MatrixXd square = by_border.transpose() * by_border;
  for (std::size_t j = 0; j < columns.size(); ++j) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      border_matrix_(columns[i], columns[j]) +=
          square(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
  }
  add_rows(border_gradient_, columns, by_border.transpose() * r);
}

std::optional<ChainEquations::Eliminated> ChainEquations::eliminate(double damping) const {
  Eliminated e{.factors = {},
               .by_border = by_border_,
               .gradient = gradient_,
               .border = border_matrix_,
               .border_gradient = border_gradient_};
  e.factors.reserve(diagonal_.size());
  e.border.diagonal() *= 1 + damping;
  MatrixXd left = MatrixXd::Zero(size_, size_);  // on this block's diagonal, by those before
  for (std::size_t k = 0; k < diagonal_.size(); ++k) {
    MatrixXd D = diagonal_[k];
    D.diagonal() *= 1 + damping;
    e.factors.emplace_back(D + left);
    const Eigen::LLT<MatrixXd>& factor = e.factors.back();
    if (!determines(factor, D.diagonal())) return std::nullopt;
    const MatrixXd of_border = factor.solve(e.by_border[k]);
    const VectorXd of_gradient = factor.solve(e.gradient[k]);
    e.border.noalias() -= e.by_border[k].transpose() * of_border;
    e.border_gradient.noalias() -= e.by_border[k].transpose() * of_gradient;
    left.setZero();
    if (next_[k].size() == 0) continue;
    left.noalias() -= next_[k].transpose() * factor.solve(next_[k]);
    e.by_border[k + 1].noalias() -= next_[k].transpose() * of_border;
    e.gradient[k + 1].noalias() -= next_[k].transpose() * of_gradient;
  }
  return e;
}

std::optional<ChainEquations::Step> ChainEquations::solve(double damping) const {
  const std::optional<Eliminated> e = eliminate(damping);
  if (!e) return std::nullopt;
  const Eigen::LLT<MatrixXd> border(e->border);
  if (border_ > 0 && !determines(border, (1 + damping) * border_matrix_.diagonal())) {
    return std::nullopt;
  }
  Step step{.blocks = std::vector<VectorXd>(diagonal_.size()),
            .border = border_ > 0 ? VectorXd(-border.solve(e->border_gradient)) : VectorXd(0)};
  for (std::size_t k = diagonal_.size(); k-- > 0;) {
    VectorXd right = -e->gradient[k] - e->by_border[k] * step.border;
    if (next_[k].size() > 0) right -= next_[k] * step.blocks[k + 1];
    step.blocks[k] = e->factors[k].solve(right);
  }
  // Half of the sum of squares falls by -g^T d / 2 - damping d^T diag d / 2 with a damped step.
  double decrease = -border_gradient_.dot(step.border);
  double damped = step.border.dot(border_matrix_.diagonal().cwiseProduct(step.border));
  for (std::size_t k = 0; k < diagonal_.size(); ++k) {
    decrease -= gradient_[k].dot(step.blocks[k]);
    damped += step.blocks[k].dot(diagonal_[k].diagonal().cwiseProduct(step.blocks[k]));
  }
  step.decrease = (decrease + damping * damped) / 2;
  return step;
}

std::optional<MatrixXd> ChainEquations::border_information() const {
  std::optional<Eliminated> e = eliminate(0);
  if (!e) return std::nullopt;
  return std::move(e->border);
}

std::optional<MatrixXd> ChainEquations::border_gradients() const {
  const std::optional<Eliminated> e = eliminate(0);
  if (!e) return std::nullopt;
  MatrixXd gradients(border_, static_cast<Eigen::Index>(diagonal_.size()));
  for (std::size_t k = 0; k < diagonal_.size(); ++k) {
    gradients.col(static_cast<Eigen::Index>(k)) =
        own_border_[k] - by_border_[k].transpose() * e->factors[k].solve(gradient_[k]);
  }
  return gradients;
}

}  // namespace chasles
