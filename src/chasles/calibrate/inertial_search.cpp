#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/base/median.hpp>
#include <chasles/calibrate/correlated_errors_detail.hpp>
#include <chasles/calibrate/inertial_search_detail.hpp>
#include <chasles/calibrate/levenberg_marquardt.hpp>

namespace chasles::calibrate_detail {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;

// That of the lenses by the pixels alone: what else these show is eliminated.
double lens_correlation(const InertialProblem& problem, const InertialLayout& layout,
                        const InertialRig& x) {
  const std::optional<LinearisedRig> pixels = problem.pixels_alone(x);
  if (!pixels) return 1;
  const auto gradients = pixels->equations.border_gradients();
  const auto information = pixels->equations.border_information();
  if (!gradients || !information) return 1;
  std::vector<int> lenses;
  for (std::size_t c = 0; c < layout.cameras(); ++c) {
    const auto rows = columns_from(layout.lens_row(c), layout.lens(c).parameters());
    lenses.insert(lenses.end(), rows.begin(), rows.end());
  }
  return correlation_factor(*information, *gradients, lenses, pieces_of(problem));
}

double inertial_scatter(const InertialProblem& problem, const InertialRig& x) {
  std::vector<double> sizes;
  for (std::size_t k = 0; k < problem.instants().size(); ++k) {
    for (const TargetView* view : problem.instants()[k].views) {
      for (const Vector2d& error : problem.errors(x, k, *view)) sizes.push_back(error.norm());
    }
  }
  return std::max(0.01, median(std::move(sizes)) / 1.17741);
}

// The states move with their instants, from the times by one offset to those by another [s].
void move_instants(InertialProblem& problem, InertialRig& x, double from, double to) {
  std::vector<InertialInstant> instants = problem.instants();
  const Time delay(static_cast<std::int64_t>(std::llround(1e9 * to) - std::llround(1e9 * from)));
  for (std::size_t k = 0; k < x.states.size(); ++k) {
    const InertialMotion later(x.states[k], x, instants[k], to - from);
    x.states[k].world_T_imu = later.world_T_imu;
    x.states[k].v_world = later.v_world;
    instants[k].time += delay;
  }
  problem.set_instants(std::move(instants));
}

}  // namespace

std::vector<int> pieces_of(const InertialProblem& problem) {
  std::vector<Instant> instants;
  for (const InertialInstant& one : problem.instants()) instants.push_back({one.time, one.views});
  return independent_pieces(instants);
}

InertialRig least_rig(InertialProblem& problem, InertialRig x, const InertialWeights& weights,
                      bool must_converge, int& iterations) {
  problem.set_sigma(weights.pixel_sigma());
  problem.make_links(x, weights.gyroscope, weights.accelerometer);
  auto found = minimised(
      std::move(x), [&](const InertialRig& rig) { return problem.linearised(rig); },
      [&](const InertialRig& rig, const ChainEquations::Step& step) {
        return problem.moved(rig, step);
      });
  if (!found) throw InputError("a lens cannot have the corners where they were found");
  iterations += found->iterations;
  if (must_converge && !found->converged) {
    throw UndeterminedError(fmt::format(
        "the search did not converge in {} steps: the motion does not determine all parameters; "
        "expected quick turns about all three axes and quick shifts, with the target in view",
        iterations));
  }
  return std::move(found->state);
}

InertialRig searched(InertialProblem& problem, const InertialLayout& layout, InertialRig x,
                     InertialWeights& weights, int& iterations) {
  constexpr int kRounds = 5;
  constexpr double kStale = 0.0005;     // change of an offset after which links begin anew [s]
  constexpr double kMostChange = 0.08;  // of the offset, for which there are samples [s]
  const double first = x.offsets[0];
  double offset = first;
  for (int round = 1; round < kRounds; ++round) {
    x = least_rig(problem, std::move(x), weights, false, iterations);
    const auto [rotation, motion] = problem.link_squares(x);
    weights.gyroscope = std::max(1.0, weights.gyroscope * std::sqrt(rotation));
    weights.accelerometer = std::max(1.0, weights.accelerometer * std::sqrt(motion));
    weights.sigma = inertial_scatter(problem, x);
    problem.set_sigma(weights.sigma);
    weights.correlation = lens_correlation(problem, layout, x);
    if (std::abs(x.offsets[0] - offset) > kStale) {
      if (std::abs(x.offsets[0] - first) > kMostChange) {
        throw InputError(fmt::format(
            "the time offset would be {:.4f} s, by the rotations it is {:.4f} s: expected both to "
            "agree within {} s: are axes and units of the accelerometer right?",
            x.offsets[0], first, kMostChange));
      }
      move_instants(problem, x, offset, x.offsets[0]);
      offset = x.offsets[0];
    }
  }
  return least_rig(problem, std::move(x), weights, true, iterations);
}

MatrixXd inertial_covariance(const InertialProblem& problem, const InertialLayout& layout,
                             const InertialRig& x) {
  const std::optional<LinearisedRig> linearised = problem.linearised(x);
  const std::optional<MatrixXd> information = linearised->equations.border_information();
  const Eigen::LLT<MatrixXd> factor(information.value_or(MatrixXd::Zero(1, 1)));
  if (!information || factor.info() != Eigen::Success) {
    throw UndeterminedError(
        "the motion does not determine all parameters: expected turns about all axes");
  }
  MatrixXd T = MatrixXd::Identity(layout.rows(), layout.rows());
  for (std::size_t c = 0; c < layout.cameras(); ++c) {
    const int row = layout.lens_row(c), n = layout.lens(c).parameters();
    T.block(row, row, n, n) = by_search_coordinates(
        layout.lens(c), search_coordinates(layout.lens(c), lens_parameters(x.cameras[c])));
  }
  return T * factor.solve(MatrixXd::Identity(layout.rows(), layout.rows())) * T.transpose();
}

}  // namespace chasles::calibrate_detail
