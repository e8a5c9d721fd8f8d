#include <Eigen/LU>

#include <chasles/smooth/window_detail.hpp>

// What a window knows of what has left it.
namespace chasles::smooth_detail {
namespace {

// xi: the chart's errors of the present numbers against those of the prior.
Eigen::VectorXd offset(const Window& window, const WindowRows& rows) {
  const WindowPrior& prior = window.prior;
  Eigen::VectorXd xi = Eigen::VectorXd::Zero(prior.gradient.size());
  for (const auto& [number, row] : rows.points) {
    xi.segment<3>(row) = window.points.at(number).parameters - prior.points.at(number);
  }
  const ChartManifold manifold(*window.chart, window.sizes.velocity);
  const int n = window.sizes.errors(), additive = window.sizes.additive;
  for (std::size_t k = 0; k < prior.keyframes.size(); ++k) {
    const int row = rows.begin + n * static_cast<int>(k);
    manifold.Minus(window.keyframes[k].motion.data(), prior.keyframes[k].motion.data(), &xi[row]);
    xi.segment(row + n - additive, additive) =
        window.keyframes[k].additive - prior.keyframes[k].additive;
  }
  return xi;
}

// M <- T^T M T (or with T's inverses) over the prior's keyframes, v <- T^T v; of M all is used.
void turn(const Window& window, const WindowRows& rows, std::size_t keyframes, bool inverse,
          Eigen::MatrixXd& M, Eigen::VectorXd& v) {
  for (std::size_t k = 0; k < keyframes; ++k) {
    Eigen::MatrixXd T = chart_block(window, window.keyframes[k]);
    if (T.isIdentity(0)) continue;
    if (inverse) T = T.inverse().eval();
    const int row = rows.begin + window.sizes.errors() * static_cast<int>(k);
    const auto n = static_cast<int>(T.rows());
    M.middleRows(row, n) = (T.transpose() * M.middleRows(row, n)).eval();
    M.middleCols(row, n) = (M.middleCols(row, n) * T).eval();
    v.segment(row, n) = (T.transpose() * v.segment(row, n)).eval();
  }
}

}  // namespace

Eigen::MatrixXd chart_block(const Window& window, const WindowKeyframe& keyframe) {
  if (!window.sizes.velocity) return pose_block(*window.chart, read_pose(keyframe.motion.data()));
  const InertialState motion = read_state(keyframe.motion.data(), keyframe.additive.data());
  State state;
  state.world_T_imu = motion.world_T_imu;
  state.v_world = motion.v_world;
  return window.chart->motion_block(state);
}

double prior_cost(const Window& window) {
  if (window.prior.gradient.size() == 0) return 0;
  const Eigen::VectorXd xi = offset(window, WindowRows(window));
  return xi.dot(window.prior.information * xi) / 2 + window.prior.gradient.dot(xi);
}

double add_prior(const Window& window, WindowSystem& system) {
  const WindowPrior& prior = window.prior;
  const Eigen::Index n = prior.gradient.size();
  if (n == 0) return 0;
  const WindowRows rows(window);
  const Eigen::VectorXd xi = offset(window, rows);
  const Eigen::VectorXd pull = prior.information * xi;
  Eigen::MatrixXd information = prior.information;
  Eigen::VectorXd gradient = prior.gradient + pull;
  turn(window, rows, prior.keyframes.size(), false, information, gradient);
  system.S.topLeftCorner(n, n) += information;
  system.g.head(n) += gradient;
  return xi.dot(pull) / 2 + prior.gradient.dot(xi);
}

void set_prior(Window& window, const WindowSystem& system) {
  WindowPrior prior{.information = system.S.selfadjointView<Eigen::Lower>(),
                    .gradient = system.g,
                    .keyframes = {window.keyframes.begin(), window.keyframes.end()},
                    .points = {}};
  for (const auto& [number, point] : window.points) {
    if (point.in_prior) prior.points[number] = point.parameters;
  }
  turn(window, WindowRows(window), prior.keyframes.size(), true, prior.information, prior.gradient);
  window.prior = std::move(prior);
}

}  // namespace chasles::smooth_detail
