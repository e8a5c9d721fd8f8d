#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace chasles {

/// The normal equations of a least-squares problem whose unknowns are a chain of blocks of one size
/// and a border: a residual depends on a block, or on two that follow each other, and on the
/// border. Memory and time are linear in the number of blocks.
class ChainEquations {
 public:
  ChainEquations(std::size_t blocks, Eigen::Index size, Eigen::Index border);

  /// Adds whitened residuals r with the derivatives by a block (rows x size) and by the unknowns
  /// `columns` of the border (rows x columns).
  void add(std::size_t block, const Eigen::MatrixXd& by_block, const Eigen::MatrixXd& by_border,
           std::span<const int> columns, const Eigen::VectorXd& r);
  /// Those of a link between `block` and the next one.
  void add_link(std::size_t block, const Eigen::MatrixXd& by_block, const Eigen::MatrixXd& by_next,
                const Eigen::MatrixXd& by_border, std::span<const int> columns,
                const Eigen::VectorXd& r);
  /// Those of the border alone.
  void add_border(const Eigen::MatrixXd& by_border, std::span<const int> columns,
                  const Eigen::VectorXd& r);

  /// The minimum of the linearised problem, relative to the present values.
  struct Step {
    std::vector<Eigen::VectorXd> blocks;
    Eigen::VectorXd border;
    double decrease = 0;  ///< of half the sum of squares, as the linear problem has it
  };
  /// With the diagonal times 1 + damping. None where the equations do not determine all unknowns.
  std::optional<Step> solve(double damping) const;

  /// The normal matrix of the border when the chain is eliminated: the inverse of the covariance of
  /// the border.
  std::optional<Eigen::MatrixXd> border_information() const;
  /// How the border's minimum depends on the residuals at each block and its link: the gradient of
  /// each block's part after elimination, one column each (border x blocks). Their sum is the
  /// gradient of the eliminated problem, zero at the minimum. Requires blocks without links.
  std::optional<Eigen::MatrixXd> border_gradients() const;

 private:
  struct Eliminated;
  std::optional<Eliminated> eliminate(double damping) const;

  Eigen::Index size_, border_;
  std::vector<Eigen::MatrixXd> diagonal_;    ///< block by itself
  std::vector<Eigen::MatrixXd> next_;        ///< block by the next one; empty without a link
  std::vector<Eigen::MatrixXd> by_border_;   ///< block by border
  std::vector<Eigen::VectorXd> gradient_;    ///< of the block
  std::vector<Eigen::VectorXd> own_border_;  ///< what each block's residuals add to the border's
  Eigen::MatrixXd border_matrix_;
  Eigen::VectorXd border_gradient_;
};

}  // namespace chasles
