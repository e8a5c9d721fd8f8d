#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/base/median.hpp>
#include <chasles/calibrate/corner_loss.hpp>
#include <chasles/calibrate/rig_search_detail.hpp>

namespace chasles::calibrate_detail {
namespace {

constexpr double kLeastSigma = 0.01;  // of corners without noise [px]

double scatter(const RigProblem& problem, const RigState& x, int parameters) {
  std::vector<double> sizes;
  for (std::size_t k = 0; k < problem.instants().size(); ++k) {
    for (const TargetView* view : problem.instants()[k].views) {
      const Camera& camera = x.cameras[static_cast<std::size_t>(view->camera)];
      for (std::size_t i = 0; i < view->ids.size(); ++i) {
        const auto image =
            project(camera, camera.cam_T_imu *
                                (x.cam0_T_target[k] * problem.corners().at(view->ids[i], x.shape)));
        if (image) sizes.push_back((image->pixel - view->pixels[i]).norm());
      }
    }
  }
  const double rows = 2 * static_cast<double>(sizes.size());
  const double unknowns = 6 * static_cast<double>(problem.instants().size()) + parameters;
  // The median of the length of two normal errors is 1.1774 sigma.
  const double freedom = std::max(0.1, 1 - unknowns / rows);
  return std::max(kLeastSigma, median(std::move(sizes)) / 1.17741 / std::sqrt(freedom));
}

}  // namespace

Solved solved(RigProblem& problem, const CamerasLayout& layout, RigState state,
              const std::string& of, const SearchLimits& limits) {
  constexpr int kRounds = 8;
  Solved result;
  problem.set_sigma(kFirstLossWidth / kLossSigmas);
  for (int round = 0; round < kRounds; ++round) {
    const auto found = minimised(
        state, [&](const RigState& x) { return problem.linearised(x); },
        [&](const RigState& x, const ChainEquations::Step& step) { return problem.moved(x, step); },
        limits);
    if (!found) {
      throw InputError(fmt::format(
          "{}: a lens cannot have the corners where they were found: expected another lens model",
          of));
    }
    state = found->state;
    result.iterations += found->iterations;
    result.squares = found->linearised.cost * problem.sigma() * problem.sigma();
    const double sigma = scatter(problem, state, layout.rows());
    const bool is_known = std::abs(sigma - problem.sigma()) < 0.01 * problem.sigma();
    if (is_known || round + 1 == kRounds) {
      if (!found->converged) {
        throw UndeterminedError(fmt::format(
            "{}: the search did not converge in {} steps: the views do not determine all "
            "parameters; expected views from other directions, nearer to the border of the image, "
            "or a lens with fewer coefficients",
            of, result.iterations));
      }
      break;
    }
    problem.set_sigma(sigma);
  }
  result.state = std::move(state);
  result.sigma = problem.sigma();
  return result;
}

}  // namespace chasles::calibrate_detail
