#include <optional>
#include <utility>
#include <vector>

#include <chasles/filter/dense.hpp>
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
  std::vector<std::optional<Eigen::MatrixXd>> turns;  // y by the reference chart's errors; none: 1
  Eigen::VectorXd y;
};

Offset offset(const Window& window, const WindowRows& rows) {
  const WindowPrior& prior = window.prior;
  Offset at{.scale = scale_of(window, rows), .numbers = {}, .turns = {}, .y = {}};
  at.numbers = scaled(window, -at.scale.log);
  at.y = errors_of(window, rows, at.numbers);
  for (std::size_t k = 0; k < prior.keyframes.size(); ++k) {
    std::optional<Eigen::MatrixXd>& turn = at.turns.emplace_back();
    const WindowKeyframe& now = at.numbers.keyframes[k];
    if (now.motion == prior.keyframes[k].motion) continue;
    const Eigen::MatrixXd& inverse = prior.inverse_blocks[k];
    const Eigen::MatrixXd G = inverse * chart_block(window, now);
    if (!G.isIdentity(0)) turn = G;
    auto y = at.y.segment(rows.begin + rows.errors * static_cast<int>(k), inverse.rows());
    y = (inverse * y).eval();
  }
  if (!prior.scale_weights.empty()) at.y += at.scale.log * prior.scale_direction;
  return at;
}

// v <- G v, or G^T v, G being 1 but for the keyframes' turns.
void multiply(const WindowRows& rows, const Offset& at, bool transposed, Eigen::VectorXd& v) {
  int row = rows.begin;
  for (const auto& G : at.turns) {
    if (G) {
      auto part = v.segment(row, G->rows());
      part = (transposed ? (G->transpose() * part).eval() : (*G * part).eval());
    }
    row += rows.errors;
  }
}

// The same of the lower triangle of a symmetric S <- G^T S G, for one keyframe of n rows.
template <int N>
void turn_keyframe(const Eigen::MatrixXd& turn, Eigen::Index row, Eigen::Index n,
                   Eigen::MatrixXd& S) {
  const Eigen::Matrix<double, N, N> G = turn, Gt = G.transpose();
  for (Eigen::Index j = 0; j < row; ++j) {
    S.block<N, 1>(row, j) = (Gt * S.block<N, 1>(row, j)).eval();
  }
  const Eigen::Matrix<double, N, N> D =
      S.block<N, N>(row, row).template selfadjointView<Eigen::Lower>();
  S.block<N, N>(row, row) = Gt * D * G;
  auto below = S.block<Eigen::Dynamic, N>(row + N, row, n - row - N, N);
  below = below.lazyProduct(G).eval();
}

void turn(const WindowRows& rows, const Offset& at, Eigen::Index n, Eigen::MatrixXd& S) {
  int row = rows.begin;
  for (const auto& G : at.turns) {
    if (G && G->rows() == kPoseErrors) turn_keyframe<kPoseErrors>(*G, row, n, S);
    if (G && G->rows() == kMotionErrors) turn_keyframe<kMotionErrors>(*G, row, n, S);
    row += rows.errors;
  }
}

Eigen::VectorXd pull(const WindowPrior& prior, const Eigen::VectorXd& y) {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(y.size());
  dense::add_symmetric_product(prior.information, y, gradient);
  return gradient;
}

// S and g by the present numbers, with the scale among the prior's coordinates: their derivative is
// G E + d c^T, where E takes the scale off, c is the scale's own derivative, and d how its
// direction has moved.
void turn_with_scale(const Window& window, const WindowRows& rows, const Offset& at, Eigen::Index n,
                     Eigen::MatrixXd& S, Eigen::VectorXd& g) {
  const Eigen::VectorXd E = scaling(window, rows, -at.scale.log);
  Eigen::VectorXd d = scale_direction(window, rows, at.numbers);
  multiply(rows, at, false, d);
  d = window.prior.scale_direction - d;
  Eigen::VectorXd by_d = pull(window.prior, d);
  const double information = d.dot(by_d), gradient = d.dot(g);
  multiply(rows, at, true, by_d);
  by_d.array() *= E.array();
  turn(rows, at, n, S);
  multiply(rows, at, true, g);
  const Eigen::VectorXd& c = at.scale.by_errors;
  by_d += information / 2 * c;
  for (Eigen::Index j = 0; j < n; ++j) {
    auto column = S.col(j).segment(j, n - j);
    column.array() *= E[j] * E.tail(n - j).array();
    column += c[j] * by_d.tail(n - j) + by_d[j] * c.tail(n - j);
  }
  g = E.cwiseProduct(g) + gradient * c;
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
  const WindowPrior& prior = window.prior;
  if (prior.gradient.size() == 0) return 0;
  const Eigen::VectorXd y = offset(window, WindowRows(window)).y;
  return y.dot(pull(prior, y)) / 2 + prior.gradient.dot(y);
}

WindowSystem prior_system(const Window& window) {
  const WindowRows rows(window);
  WindowSystem system{.S = Eigen::MatrixXd::Zero(rows.size, rows.size),
                      .g = Eigen::VectorXd::Zero(rows.size)};
  const WindowPrior& prior = window.prior;
  const Eigen::Index n = prior.gradient.size();
  if (n == 0) return system;
  const Offset at = offset(window, rows);
  system.S.topLeftCorner(n, n) = prior.information;
  Eigen::VectorXd g = prior.gradient + pull(prior, at.y);
  if (prior.scale_weights.empty()) {
    turn(rows, at, n, system.S);
    multiply(rows, at, true, g);
  } else {
    turn_with_scale(window, rows, at, n, system.S, g);
  }
  system.g.head(n) = g;
  return system;
}

void set_prior(Window& window, WindowSystem system) {
  window.prior = {.information = std::move(system.S),
                  .gradient = std::move(system.g),
                  .keyframes = {window.keyframes.begin(), window.keyframes.end()},
                  .points = {}};
  WindowPrior& prior = window.prior;
  for (const auto& [number, point] : window.points) {
    if (point.in_prior) prior.points[number] = point.parameters;
  }
  for (const WindowKeyframe& keyframe : prior.keyframes) {
    const Eigen::MatrixXd T = chart_block(window, keyframe);
    prior.inverse_blocks.push_back(small::inverse(T));
  }
  weigh_scale(window, prior);
  if (prior.scale_weights.empty()) return;
  prior.scale_direction = scale_direction(window, WindowRows(window),
                                          {.keyframes = prior.keyframes, .points = prior.points});
}

}  // namespace chasles::smooth_detail
