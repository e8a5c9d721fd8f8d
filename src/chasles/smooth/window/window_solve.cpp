#include <algorithm>
#include <cmath>

#include <chasles/filter/dense.hpp>
#include <chasles/smooth/window/window_inner_detail.hpp>

// Steps to a window's minimum, and the Schur complement there.
namespace chasles::smooth_detail {
namespace {

constexpr double kFirstDamping = 1e-4, kMostDamping = 1e4;

// The values of a window, to restore them.
struct Numbers {
  std::deque<WindowKeyframe> keyframes;
  std::vector<double> calibration;
  std::vector<Eigen::Vector3d> points;
};

Numbers numbers_of(const Window& window) {
  Numbers numbers{.keyframes = window.keyframes, .calibration = window.calibration, .points = {}};
  for (const auto& [number, point] : window.points) numbers.points.push_back(point.parameters);
  return numbers;
}

void restore(const Numbers& numbers, Window& window) {
  window.keyframes = numbers.keyframes;
  window.calibration = numbers.calibration;
  auto parameters = numbers.points.begin();
  for (auto& [number, point] : window.points) point.parameters = *parameters++;
  update_axes(window);
  window.stale = true;
}

// Whether none of its errors moves. A step of zero would orthonormalise the rotation.
bool is_held(const Window& window, const CalibrationBlocks::Block& block) {
  return std::ranges::count_if(window.considered.rows, [&](int row) {
           return row >= block.row && row < block.row + block.errors;
         }) == block.errors;
}

void move_calibration(const WindowRows& rows, const Eigen::VectorXd& step, Window& window) {
  const ChartManifold extrinsics(kStandardChart, false);
  for (const auto& block : window.sizes.calibration.all()) {
    if (is_held(window, block)) continue;
    double* x = window.calibration.data() + block.number;
    const double* by = step.data() + rows.calibration + block.row;
    if (block.is_pose) {
      std::array<double, kPoseNumbers> from{};
      std::copy_n(x, kPoseNumbers, from.begin());
      extrinsics.Plus(from.data(), by, x);
    } else {
      for (int i = 0; i < block.errors; ++i) x[i] += by[i];
    }
  }
  update_axes(window);
}

void move(const WindowRows& rows, const Eigen::VectorXd& step, double damping, Window& window) {
  // Landmarks first: their equations are at the present poses.
  for (auto& [number, point] : window.points) {
    const auto row = rows.points.find(number);
    if (row != rows.points.end()) {
      point.parameters += step.segment<3>(row->second);
      continue;
    }
    Eigen::Vector3d right = -point.linear.b;
    for (const PointLinear::PoseBlock& pose_block : point.linear.pose_blocks) {
      right -= pose_block.W.transpose() * step.segment<6>(rows.keyframe(pose_block.keyframe));
    }
    if (rows.calibration_errors > 0) {
      right -= point.linear.calibration.W.transpose() *
               step.segment(rows.calibration, rows.calibration_errors);
    }
    point.parameters += point.linear.damped_inverse(damping) * right;
  }
  move_calibration(rows, step, window);
  const ChartManifold manifold(*window.chart, window.sizes.velocity);
  const int additive = window.sizes.additive, moved = rows.errors - additive;
  int row = rows.begin;
  for (WindowKeyframe& keyframe : window.keyframes) {
    const Eigen::VectorXd xi = chart_block(window, keyframe) * step.segment(row, moved);
    const auto from = keyframe.motion;
    manifold.Plus(from.data(), xi.data(), keyframe.motion.data());
    keyframe.additive += step.segment(row + moved, additive);
    row += rows.errors;
  }
  window.stale = true;
}

// The columns of S by the considered errors, without their own rows. In the system, these rows and
// columns become the identity's.
Eigen::MatrixXd take_considered(const Window& window, const WindowRows& rows,
                                WindowSystem& system) {
  const std::vector<int>& considered = window.considered.rows;
  Eigen::MatrixXd& S = system.S;
  Eigen::MatrixXd columns(S.rows(), std::ssize(considered));
  Eigen::Index column = 0;
  for (const int of : considered) {
    const int row = rows.calibration + of;
    columns.col(column).head(row) = S.row(row).head(row).transpose();
    columns.col(column++).tail(S.rows() - row) = S.col(row).tail(S.rows() - row);
  }
  for (const int of : considered) {
    const int row = rows.calibration + of;
    S.row(row).head(row).setZero();
    S.col(row).tail(S.rows() - row).setZero();
    S(row, row) = 1;
    system.g[row] = 0;
    columns.row(row).setZero();
  }
  return columns;
}

// The factor at the present values, and what a step needs besides: gradient and inner errors.
struct Linearised {
  WindowFactor factor = {};
  Eigen::VectorXd g = {};
  InnerStates inner;
};

// None: the system is not positive definite.
std::optional<Linearised> factorise(double damping, const Window& window) {
  const WindowRows rows = WindowRows::outer(window);
  Linearised at{.inner = InnerStates(window, rows)};
  WindowSystem system = normal_equations(window, rows, damping, at.inner);
  if (!at.inner.eliminate(system)) return std::nullopt;
  const bool considers = !window.considered.rows.empty();
  Eigen::MatrixXd columns;
  if (considers) columns = take_considered(window, rows, system);
  if (!dense::cholesky(system.S)) return std::nullopt;
  if (considers) dense::solve_lower(system.S, columns);
  at.factor = {.L = std::move(system.S), .by_considered = std::move(columns), .rows = rows};
  at.g = std::move(system.g);
  return at;
}

// One step from the present values.
void step(const Linearised& at, double damping, Window& window) {
  const auto L = at.factor.L.triangularView<Eigen::Lower>();
  Eigen::VectorXd x = -at.g;
  L.solveInPlace(x);
  L.transpose().solveInPlace(x);
  const WindowRows all(window);
  move(all, at.inner.with_inner(x, all), damping, window);
}

// The decrease of the cost that another step would bring, if second derivatives are still those of
// an earlier linearisation. Needs current linear parts.
double predicted_decrease(const Window& window, const Linearised& before) {
  const WindowRows all(window);
  auto [decrease, g] = before.inner.reduced(gradient(window, all), all);
  for (const int row : window.considered.rows) g[before.factor.rows->calibration + row] = 0;
  before.factor.L.triangularView<Eigen::Lower>().solveInPlace(g);
  decrease += g.squaredNorm() / 2;
  for (const auto& [number, point] : window.points) {
    if (point.in_prior) continue;
    decrease += point.linear.b.dot(point.linear.V_inverse * point.linear.b) / 2;
  }
  return decrease;
}

}  // namespace

WindowProgress improve(Window& window, const WindowSteps& steps, WindowFactor& factor) {
  WindowProgress progress{.cost = evaluate(window)};
  double damping = 0;
  bool damped = false;
  while (progress.successful < steps.steps && !progress.converged && damping <= kMostDamping) {
    const Numbers before = numbers_of(window);
    ++progress.tried;
    std::optional<Linearised> at = factorise(damping, window);
    if (at) step(*at, damping, window);
    damped = damping > 0 || !at;
    const double cost = at ? evaluate(window) : std::nan("");
    const double gain = progress.cost - cost, least = steps.tolerance * std::abs(progress.cost);
    if (gain >= -least) {
      ++progress.successful;
      progress.converged =
          gain <= least || (progress.successful < steps.steps && !damped &&
                            predicted_decrease(window, *at) < steps.least_decrease);
      progress.cost = cost;
      damping = damping > kFirstDamping ? damping / 10 : 0;
    } else {
      restore(before, window);
      evaluate(window);
      damping = damping > 0 ? 10 * damping : kFirstDamping;
    }
    factor = at ? std::move(at->factor) : WindowFactor{};
  }
  // The uncertainty is defined without damping.
  if (damped) factor = factor_of(window);
  progress.finite = std::isfinite(progress.cost) && factor.rows.has_value();
  return progress;
}

WindowFactor factor_of(const Window& window) {
  std::optional<Linearised> at = factorise(0, window);
  return at ? std::move(at->factor) : WindowFactor{};
}

Culled cull(Window& window, double gate) {
  Culled culled;
  for (auto& [number, point] : window.points) {
    const bool began_with = std::ranges::any_of(point.views, &WindowView::begins);
    const auto wrong = [&](const WindowView& view) { return view.whitened_norm > gate; };
    for (const WindowView& view : point.views) {
      if (!wrong(view)) continue;
      culled.views.push_back({.point = number, .keyframe = view.keyframe, .camera = view.camera});
    }
    if (std::erase_if(point.views, wrong) == 0) continue;
    point.stale = true;
    const bool begins = std::ranges::any_of(point.views, &WindowView::begins);
    if (!point.in_prior && (point.views.size() < 2 || began_with != begins)) {
      culled.points.push_back(number);
    }
  }
  return culled;
}

}  // namespace chasles::smooth_detail
