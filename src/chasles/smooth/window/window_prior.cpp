#include <algorithm>
#include <utility>
#include <vector>

#include <chasles/filter/dense.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/smooth/window/window_detail.hpp>

// The prior of a window from its marginalised states.
namespace chasles::smooth_detail {

// y of a keyframe by the reference chart's errors, at other values than the prior's.
struct Turn {
  int row = 0;
  Eigen::MatrixXd G;
};

namespace {

// The chart's errors of these values against those of the prior.
Eigen::VectorXd chart_errors(const Window& window, const WindowRows& rows,
                             const ScaledNumbers& numbers) {
  const WindowPrior& prior = window.prior;
  Eigen::VectorXd xi = Eigen::VectorXd::Zero(prior.gradient.size());
  for (const auto& [number, row] : rows.points) {
    xi.segment<3>(row) = numbers.points.at(number) - prior.points.at(number);
  }
  if (rows.calibration_errors > 0) {
    xi.segment(rows.calibration, rows.calibration_errors) =
        difference(window.sizes.calibration, window.calibration.data(), prior.calibration.data());
  }
  const ChartManifold manifold(*window.chart, window.sizes.velocity);
  Eigen::VectorXd errors(window.sizes.errors());
  for (std::size_t k = 0; k < prior.keyframes.size(); ++k) {
    const WindowKeyframe& now = numbers.keyframes[k];
    manifold.Minus(now.motion.data(), prior.keyframes[k].motion.data(), errors.data());
    errors.tail(window.sizes.additive) = now.additive - prior.keyframes[k].additive;
    const int number = rows.first + static_cast<int>(k);
    xi.segment(rows.keyframe(number), rows.errors_of(number)) = errors.head(rows.errors_of(number));
  }
  return xi;
}

// The prior's coordinates of the present values: those of the values without the scale, and the
// scale.
struct Offset {
  WindowScale scale;
  ScaledNumbers numbers;
  Eigen::VectorXd y;
};

Offset offset(const Window& window, const WindowRows& rows) {
  const WindowPrior& prior = window.prior;
  Offset at{.scale = scale_of(window, rows), .numbers = {}, .y = {}};
  at.numbers = scaled(window, -at.scale.log);
  at.y = chart_errors(window, rows, at.numbers);
  int number = rows.first;
  for (const Eigen::MatrixXd& inverse : prior.inverse_blocks) {
    auto y = at.y.segment(rows.keyframe(number++), inverse.rows());
    y = (inverse * y).eval();
  }
  if (!prior.scale_weights.empty()) at.y += at.scale.log * prior.scale_direction;
  return at;
}

// G is the identity but for these blocks.
std::vector<Turn> turns_of(const Window& window, const WindowRows& rows,
                           const ScaledNumbers& numbers) {
  const WindowPrior& prior = window.prior;
  std::vector<Turn> turns;
  for (std::size_t k = 0; k < prior.keyframes.size(); ++k) {
    const WindowKeyframe& now = numbers.keyframes[k];
    if (now.motion == prior.keyframes[k].motion) continue;
    const Eigen::MatrixXd& inverse = prior.inverse_blocks[k];
    const auto n = inverse.rows();
    const Eigen::MatrixXd G = inverse * chart_block(window, now).topLeftCorner(n, n);
    if (G.isIdentity(0)) continue;
    turns.push_back({.row = rows.keyframe(rows.first + static_cast<int>(k)), .G = G});
  }
  for (const auto& block : window.sizes.calibration.all()) {
    if (!block.is_pose) continue;
    const SE3 at = read_pose(window.calibration.data() + block.number);
    const SE3 from = read_pose(prior.calibration.data() + block.number);
    if (at.R == from.R) continue;
    Matrix6d G = Matrix6d::Identity();
    G.topLeftCorner<3, 3>() = so3::left_jacobian_inverse(so3::log(at.R * from.R.transpose()));
    turns.push_back({.row = rows.calibration + block.row, .G = G});
  }
  return turns;
}

// v <- G v, or G^T v.
void multiply(const std::vector<Turn>& turns, bool transposed, Eigen::VectorXd& v) {
  for (const auto& [row, G] : turns) {
    auto part = v.segment(row, G.rows());
    part = (transposed ? (G.transpose() * part).eval() : (G * part).eval());
  }
}

// The lower triangle of a symmetric S <- G^T S G, where G is the identity but for N rows.
template <int N>
void turn_rows(const Eigen::MatrixXd& block, Eigen::Index row, Eigen::MatrixXd& S) {
  const Eigen::Matrix<double, N, N> G = block, Gt = G.transpose();
  for (Eigen::Index j = 0; j < row; ++j) {
    S.block<N, 1>(row, j) = (Gt * S.block<N, 1>(row, j)).eval();
  }
  const Eigen::Matrix<double, N, N> own =
      S.block<N, N>(row, row).template selfadjointView<Eigen::Lower>();
  S.block<N, N>(row, row) = Gt * own * G;
  auto below = S.block<Eigen::Dynamic, N>(row + N, row, S.rows() - row - N, N);
  below = below.lazyProduct(G).eval();
}

void turn(const std::vector<Turn>& turns, Eigen::MatrixXd& S) {
  for (const auto& [row, G] : turns) {
    if (G.rows() == kPoseErrors) {
      turn_rows<kPoseErrors>(G, row, S);
    } else {
      turn_rows<kMotionErrors>(G, row, S);
    }
  }
}

Eigen::VectorXd times_information(const WindowPrior& prior, const Eigen::VectorXd& y) {
  Eigen::VectorXd product = Eigen::VectorXd::Zero(y.size());
  dense::add_symmetric_product(prior.information, y, product);
  return product;
}

}  // namespace

// With the scale among the prior's coordinates, their derivative by the present values is
// G E + d c^T, where G are the turns, E removes the scale, c is the scale's derivative, and d the
// change of its direction. Without it, E is 1 and there is no d.
struct PresentPrior {
  explicit PresentPrior(const Window& window);

  WindowRows rows;
  WindowScale scale;
  std::vector<Turn> turns;
  Eigen::VectorXd E = {}, d = {};
  Eigen::VectorXd g;
  double cost = 0;
};

PresentPrior::PresentPrior(const Window& window) : rows(prior_rows(window)) {
  const WindowPrior& prior = window.prior;
  g = prior.gradient;
  if (g.size() == 0) return;
  Offset at = offset(window, rows);
  turns = turns_of(window, rows, at.numbers);
  const Eigen::VectorXd by_y = times_information(prior, at.y);
  cost = at.y.dot(by_y) / 2 + prior.gradient.dot(at.y);
  g += by_y;
  scale = std::move(at.scale);
  double along = 0;
  if (!prior.scale_weights.empty()) {
    E = scaling(window, rows, -scale.log);
    d = scale_direction(window, rows, at.numbers);
    multiply(turns, false, d);
    d = prior.scale_direction - d;
    along = d.dot(g);
  }
  multiply(turns, true, g);
  if (d.size() > 0) g = E.cwiseProduct(g) + along * scale.by_errors;
}

namespace {

std::shared_ptr<const PresentPrior> present_of(const Window& window) {
  if (!window.stale && window.prior.present) return window.prior.present;
  return std::make_shared<const PresentPrior>(window);
}

// The information by the present values; lower triangle.
Eigen::MatrixXd present_information(const Window& window, const PresentPrior& present) {
  Eigen::MatrixXd S = window.prior.information;
  turn(present.turns, S);
  if (present.d.size() == 0) return S;
  const Eigen::VectorXd &E = present.E, &c = present.scale.by_errors;
  Eigen::VectorXd by_d = times_information(window.prior, present.d);
  const double information = present.d.dot(by_d);
  multiply(present.turns, true, by_d);
  by_d = E.cwiseProduct(by_d) + information / 2 * c;
  for (Eigen::Index j = 0; j < S.cols(); ++j) {
    const Eigen::Index n = S.cols() - j;
    auto column = S.col(j).tail(n);
    column.array() *= E[j] * E.tail(n).array();
    column += c[j] * by_d.tail(n) + by_d[j] * c.tail(n);
  }
  return S;
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

void add_calibration(Window& window, const Calibration& at, const Calibration& mean,
                     const Eigen::MatrixXd& whitening, std::size_t cameras) {
  window.sizes.calibration = CalibrationBlocks(at);
  const CalibrationBlocks& blocks = window.sizes.calibration;
  window.calibration.resize(static_cast<std::size_t>(blocks.numbers()));
  write_calibration(at, window.calibration.data());
  for (std::size_t i = 0; i < cameras; ++i) {
    window.camera_blocks.push_back(blocks.of_camera(static_cast<int>(i)));
  }
  WindowPrior& prior = window.prior;
  prior.information = whitening.transpose() * whitening;
  prior.gradient.setZero(blocks.errors());
  prior.calibration.resize(window.calibration.size());
  write_calibration(mean, prior.calibration.data());
}

WindowRows prior_rows(const Window& window) {
  return {window, static_cast<int>(window.prior.keyframes.size()), 1};
}

void evaluate_prior(Window& window) {
  window.prior.present = std::make_shared<const PresentPrior>(window);
}

double prior_cost(const Window& window) { return present_of(window)->cost; }

Eigen::VectorXd prior_gradient(const Window& window) { return present_of(window)->g; }

WindowSystem prior_system(const Window& window) {
  const auto present = present_of(window);
  return {.S = present_information(window, *present), .g = present->g};
}

void set_prior(Window& window, WindowSystem system) {
  window.prior = {.information = std::move(system.S),
                  .gradient = std::move(system.g),
                  .keyframes = {window.keyframes.begin(), window.keyframes.end()},
                  .points = {}};
  WindowPrior& prior = window.prior;
  prior.calibration = window.calibration;
  for (const auto& [number, point] : window.points) {
    if (point.in_prior) prior.points.emplace(number, point.parameters);
  }
  const WindowRows rows = prior_rows(window);
  int number = rows.first;
  for (const WindowKeyframe& keyframe : prior.keyframes) {
    const Eigen::MatrixXd T = chart_block(window, keyframe);
    const auto n = std::min<Eigen::Index>(T.rows(), rows.errors_of(number++));
    prior.inverse_blocks.push_back(small::inverse(T.topLeftCorner(n, n)));
  }
  weigh_scale(window, prior);
  if (prior.scale_weights.empty()) return;
  prior.scale_direction =
      scale_direction(window, rows, {.keyframes = prior.keyframes, .points = prior.points});
}

}  // namespace chasles::smooth_detail
