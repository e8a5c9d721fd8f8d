#pragma once

#include <vector>

#include <Eigen/Core>

namespace chasles {

/// A proposed match of an observation and a landmark, by index.
struct ProposedMatch {
  int observation = 0;
  int landmark = 0;
};

/// The largest set found of matches whose innovations are jointly compatible.
struct JointMatches {
  std::vector<int> matches;  ///< indices, rising; an observation or a landmark occurs once
  double square = 0;         ///< r^T S^-1 r of all of them together
  int runner_up = 0;         ///< size of the largest other set found, without a common match
};

/// Individually compatible nearest neighbours depend on each other through the pose: given one
/// match, the others are predicted far better. From every match in turn, the one is added that is
/// nearest to its prediction given those before (Neira & Tardos, IEEE T-RA 2001; here greedily,
/// not by branch and bound), while it passes its gate. `r` has two rows per match, `S` is
/// the joint covariance; a set passes if r^T S^-1 r is below the quantile `probability` of chi2.
JointMatches jointly_compatible(const std::vector<ProposedMatch>& proposed,
                                const Eigen::VectorXd& r, const Eigen::MatrixXd& S,
                                double probability);

/// r^T (S + noise I)^-1 r of some matches together, with the noise in px^2: chi2 with twice their
/// number of degrees of freedom.
double joint_square(const std::vector<int>& matches, const Eigen::VectorXd& r,
                    const Eigen::MatrixXd& S, double noise);

/// Matches that determine much, in the order of choice, and the information of all of them [nat].
struct Informative {
  std::vector<int> matches;
  double nats = 0;
};

/// Of some matches, in turn the one with the largest information 1/2 log det(S R^-1) of its
/// innovation given those before, while it is at least `least`. S is the joint covariance of all
/// innovations, with the noise R = noise I [px^2].
Informative most_informative(const std::vector<int>& matches, const Eigen::MatrixXd& S,
                             double noise, double least);

}  // namespace chasles
