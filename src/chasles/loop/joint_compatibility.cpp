#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include <chasles/eval/chi2.hpp>
#include <chasles/loop/joint_compatibility.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

// The innovations given those of the chosen matches.
class Given {
 public:
  Given(VectorXd r, MatrixXd S) : r_(std::move(r)), S_(std::move(S)) {}

  double square(int i) const {
    const Vector2d r = r_.segment<2>(2 * Index{i});
    return r.dot(block(i).inverse() * r);
  }
  double information(int i, double noise) const {
    return std::log(block(i).determinant() / (noise * noise)) / 2;
  }
  void condition_on(int i) {
    const MatrixXd K = S_.middleCols<2>(2 * Index{i}) * block(i).inverse();
    const Vector2d r = r_.segment<2>(2 * Index{i});
    const MatrixXd rows = S_.middleRows<2>(2 * Index{i});
    r_ -= K * r;
    S_.noalias() -= K * rows;
  }

 private:
  Matrix2d block(int i) const { return S_.block<2, 2>(2 * Index{i}, 2 * Index{i}); }

  VectorXd r_;
  MatrixXd S_;
};

bool excludes(const ProposedMatch& a, const ProposedMatch& b) {
  return a.observation == b.observation || a.landmark == b.landmark;
}

struct Set {
  std::vector<int> matches;
  double square = 0;
};

Set grown_from(int first, const std::vector<ProposedMatch>& proposed, Given given,
               const std::vector<double>& limits) {
  Set set;
  std::vector<int> open(proposed.size());
  for (std::size_t i = 0; i < open.size(); ++i) open[i] = static_cast<int>(i);
  int next = first;
  double square = given.square(first);
  while (square <= limits[1] && set.square + square <= limits[set.matches.size() + 1]) {
    set.matches.push_back(next);
    set.square += square;
    given.condition_on(next);
    const ProposedMatch& taken = proposed[static_cast<std::size_t>(next)];
    std::erase_if(open,
                  [&](int i) { return excludes(proposed[static_cast<std::size_t>(i)], taken); });
    if (open.empty()) break;
    next = *std::ranges::min_element(open, {}, [&](int i) { return given.square(i); });
    square = given.square(next);
  }
  std::ranges::sort(set.matches);
  return set;
}

bool is_better(const Set& a, const Set& b) {
  if (a.matches.size() != b.matches.size()) return a.matches.size() > b.matches.size();
  return a.square < b.square;
}

}  // namespace

JointMatches jointly_compatible(const std::vector<ProposedMatch>& proposed, const VectorXd& r,
                                const MatrixXd& S, double probability) {
  std::vector<double> limits{0};  // by the number of matches
  for (std::size_t i = 1; i <= proposed.size(); ++i) {
    limits.push_back(chi2_quantile(probability, 2.0 * static_cast<double>(i)));
  }
  std::vector<Set> sets;
  const Given given(r, S);
  for (std::size_t i = 0; i < proposed.size(); ++i) {
    sets.push_back(grown_from(static_cast<int>(i), proposed, given, limits));
  }
  JointMatches result;
  const auto best = std::ranges::min_element(sets, is_better);
  if (best == sets.end()) return result;
  result.matches = best->matches;
  result.square = best->square;
  for (const Set& other : sets) {
    const bool disjoint = std::ranges::none_of(
        other.matches, [&](int i) { return std::ranges::binary_search(result.matches, i); });
    if (disjoint) {
      result.runner_up = std::max(result.runner_up, static_cast<int>(other.matches.size()));
    }
  }
  return result;
}

double joint_square(const std::vector<int>& matches, const VectorXd& r, const MatrixXd& S,
                    double noise) {
  Given given(r, S + noise * MatrixXd::Identity(S.rows(), S.cols()));
  double square = 0;
  for (const int i : matches) {
    square += given.square(i);
    given.condition_on(i);
  }
  return square;
}

Informative most_informative(const std::vector<int>& matches, const MatrixXd& S, double noise,
                             double least) {
  Given given(VectorXd::Zero(S.rows()), S);
  std::vector<int> open = matches;
  Informative result;
  while (!open.empty()) {
    const auto best =
        std::ranges::max_element(open, {}, [&](int i) { return given.information(i, noise); });
    const double gain = given.information(*best, noise);
    if (!(gain >= least)) break;
    result.nats += gain;
    result.matches.push_back(*best);
    given.condition_on(*best);
    open.erase(best);
  }
  return result;
}

}  // namespace chasles
