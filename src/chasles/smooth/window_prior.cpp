#include <optional>
#include <vector>

#include <chasles/lie/small_matrices.hpp>
#include <chasles/smooth/window_detail.hpp>

// What a window knows of what has left it.
namespace chasles::smooth_detail {
namespace {

// The chart's errors of those numbers against those of the prior.
Eigen::VectorXd errors_of(const Window& window, const WindowRows& rows,
                          const ScaledNumbers& numbers) {
  const WindowPrior& prior = window.prior;
  Eigen::VectorXd xi = Eigen::VectorXd::Zero(prior.gradient.size());
  for (const auto& [number, row] : rows.points) {
    xi.segment<3>(row) = numbers.points.at(number) - prior.points.at(number);
  }
  const ChartManifold manifold(*window.chart, window.sizes.velocity);
  const int n = window.sizes.errors(), additive = window.sizes.additive;
  for (std::size_t k = 0; k < prior.keyframes.size(); ++k) {
    const int row = rows.begin + n * static_cast<int>(k);
    const WindowKeyframe& now = numbers.keyframes[k];
    manifold.Minus(now.motion.data(), prior.keyframes[k].motion.data(), &xi[row]);
    xi.segment(row + n - additive, additive) = now.additive - prior.keyframes[k].additive;
  }
  return xi;
}

// The prior's coordinates of the present numbers: those of the numbers without what they are larger
// by, and that.
struct Offset {
  WindowScale scale;
  ScaledNumbers numbers;
  Eigen::VectorXd xi;
};

Offset offset(const Window& window, const WindowRows& rows) {
  Offset at{.scale = scale_of(window, rows), .numbers = {}, .xi = {}};
  at.numbers = scaled(window, -at.scale.log);
  at.xi = errors_of(window, rows, at.numbers);
  if (!window.prior.scale_weights.empty()) at.xi += at.scale.log * window.prior.scale_direction;
  return at;
}

// T of a keyframe, or its inverse; none where it is 1.
std::optional<Eigen::MatrixXd> turning(const Window& window, const WindowKeyframe& keyframe,
                                       bool inverse) {
  const Eigen::MatrixXd T = chart_block(window, keyframe);
  if (T.isIdentity(0)) return std::nullopt;
  return inverse ? small::inverse(T) : T;
}

// v <- T^T v over those keyframes, or T v.
void multiply(const Window& window, const WindowRows& rows,
              const std::vector<WindowKeyframe>& keyframes, bool transposed, Eigen::VectorXd& v) {
  int row = rows.begin;
  for (const WindowKeyframe& keyframe : keyframes) {
    if (const auto T = turning(window, keyframe, false)) {
      auto part = v.segment(row, T->rows());
      part = (transposed ? (T->transpose() * part).eval() : (*T * part).eval());
    }
    row += rows.errors;
  }
}

// M <- T^T M T (or with T's inverses) over those keyframes, v <- T^T v; of M all is used.
void turn(const Window& window, const WindowRows& rows,
          const std::vector<WindowKeyframe>& keyframes, bool inverse, Eigen::MatrixXd& M,
          Eigen::VectorXd& v) {
  int row = rows.begin;
  for (const WindowKeyframe& keyframe : keyframes) {
    if (const auto T = turning(window, keyframe, inverse)) {
      const auto n = T->rows();
      M.middleRows(row, n) = (T->transpose() * M.middleRows(row, n)).eval();
      M.middleCols(row, n) = (M.middleCols(row, n) * *T).eval();
      v.segment(row, n) = (T->transpose() * v.segment(row, n)).eval();
    }
    row += rows.errors;
  }
}

// The same with the scale among the coordinates: their derivative is T E + d c^T, where E takes the
// scale off, c is the scale's own derivative, and d how its direction has moved.
void turn_with_scale(const Window& window, const WindowRows& rows, const Offset& at,
                     WindowSystem& system) {
  const Eigen::VectorXd E = scaling(window, rows, -at.scale.log);
  Eigen::VectorXd d = scale_direction(window, rows, at.numbers);
  multiply(window, rows, at.numbers.keyframes, false, d);
  d = window.prior.scale_direction - d;
  Eigen::VectorXd by_d = system.S * d;
  const double information = d.dot(by_d), gradient = d.dot(system.g);
  multiply(window, rows, at.numbers.keyframes, true, by_d);
  by_d.array() *= E.array();
  turn(window, rows, at.numbers.keyframes, false, system.S, system.g);
  const Eigen::VectorXd& c = at.scale.by_errors;
  system.S = (E.asDiagonal() * system.S * E.asDiagonal()).eval();
  system.S += c * by_d.transpose() + by_d * c.transpose() + information * c * c.transpose();
  system.g = E.cwiseProduct(system.g) + gradient * c;
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
  const Eigen::VectorXd xi = offset(window, WindowRows(window)).xi;
  return xi.dot(window.prior.information * xi) / 2 + window.prior.gradient.dot(xi);
}

double add_prior(const Window& window, WindowSystem& system) {
  const WindowPrior& prior = window.prior;
  const Eigen::Index n = prior.gradient.size();
  if (n == 0) return 0;
  const WindowRows rows(window);
  const Offset at = offset(window, rows);
  const Eigen::VectorXd pull = prior.information * at.xi;
  WindowSystem turned{.S = prior.information, .g = prior.gradient + pull};
  if (prior.scale_weights.empty()) {
    turn(window, rows, at.numbers.keyframes, false, turned.S, turned.g);
  } else {
    turn_with_scale(window, rows, at, turned);
  }
  system.S.topLeftCorner(n, n) += turned.S;
  system.g.head(n) += turned.g;
  return at.xi.dot(pull) / 2 + prior.gradient.dot(at.xi);
}

void set_prior(Window& window, const WindowSystem& system) {
  WindowPrior prior{.information = system.S.selfadjointView<Eigen::Lower>(),
                    .gradient = system.g,
                    .keyframes = {window.keyframes.begin(), window.keyframes.end()},
                    .points = {}};
  for (const auto& [number, point] : window.points) {
    if (point.in_prior) prior.points[number] = point.parameters;
  }
  const WindowRows rows(window);
  weigh_scale(window, system, prior);
  turn(window, rows, prior.keyframes, true, prior.information, prior.gradient);
  window.prior = std::move(prior);
  if (window.prior.scale_weights.empty()) return;
  Eigen::VectorXd& s = window.prior.scale_direction;
  s = scale_direction(window, rows,
                      {.keyframes = window.prior.keyframes, .points = window.prior.points});
  multiply(window, rows, window.prior.keyframes, false, s);
}

}  // namespace chasles::smooth_detail
