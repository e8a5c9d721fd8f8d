#include <algorithm>
#include <cmath>
#include <limits>

#include <chasles/smooth/window/window_detail.hpp>

// The terms of a window and their derivatives at the present values.
namespace chasles::smooth_detail {
namespace {

constexpr int kMostRows = 4;

template <int Rows, int Columns>
using Rowwise = Eigen::Map<const Eigen::Matrix<double, Rows, Columns, Eigen::RowMajor>, 0,
                           Eigen::OuterStride<>>;

// A view's residual and its derivatives as written by a cost function.
struct Written {
  std::array<double, kMostRows> residual;
  std::array<double, kMostRows * kMotionNumbers> by_view, by_anchor;
  std::array<double, 3 * kMostRows> by_point;
};

PointLinear::PoseBlock& pose_block_of(int keyframe, std::size_t from,
                                      std::vector<PointLinear::PoseBlock>& pose_blocks) {
  // Views are sorted by keyframe: the pose block, if it exists, is the last one.
  if (pose_blocks.size() > from && pose_blocks.back().keyframe == keyframe)
    return pose_blocks.back();
  return pose_blocks.emplace_back(PointLinear::PoseBlock{.keyframe = keyframe});
}

template <int Rows>
void add(const Written& at, double weight, int width, PointLinear::PoseBlock* view,
         PointLinear::PoseBlock* anchor, PointLinear& linear) {
  const Eigen::Map<const Eigen::Matrix<double, Rows, 1>> r(at.residual.data());
  const Rowwise<Rows, 3> P(at.by_point.data(), Eigen::OuterStride<>(3));
  const Eigen::Matrix<double, 3, Rows> Pt = weight * P.transpose();
  linear.V.noalias() += Pt * P;
  linear.b.noalias() += Pt * r;
  if (view == nullptr) return;
  const Eigen::Matrix<double, Rows, 6> J =
      Rowwise<Rows, 6>(at.by_view.data(), Eigen::OuterStride<>(width));
  const Eigen::Matrix<double, 6, Rows> Jt = weight * J.transpose();
  view->H.noalias() += Jt * J;
  view->W.noalias() += Jt * P;
  view->g.noalias() += Jt * r;
  if (anchor == nullptr) return;
  const Eigen::Matrix<double, Rows, 6> A =
      Rowwise<Rows, 6>(at.by_anchor.data(), Eigen::OuterStride<>(width));
  const Eigen::Matrix<double, 6, Rows> At = weight * A.transpose();
  anchor->H.noalias() += At * A;
  anchor->W.noalias() += At * P;
  anchor->g.noalias() += At * r;
  view->by_anchor.noalias() += Jt * A;
}

void add(int rows, const Written& at, double weight, int width, PointLinear::PoseBlock* view,
         PointLinear::PoseBlock* anchor, PointLinear& linear) {
  if (rows == 2) return add<2>(at, weight, width, view, anchor, linear);
  if (rows == 3) return add<3>(at, weight, width, view, anchor, linear);
  add<4>(at, weight, width, view, anchor, linear);
}

double square(const Written& at, int rows) {
  double sum = 0;
  for (int i = 0; i < rows; ++i)
    sum += at.residual[static_cast<std::size_t>(i)] * at.residual[static_cast<std::size_t>(i)];
  return sum;
}

// Value and slope of a robust loss. The slope weights the squares (iteratively reweighted least
// squares: the gradient is exact, the second derivative that of the weighted squares).
double loss_at(const Window& window, double square, double& weight) {
  weight = 1;
  if (!window.loss) return square / 2;
  std::array<double, 3> rho{};
  window.loss->Evaluate(square, rho.data());
  weight = rho[1];
  return rho[0] / 2;
}

void add_view(const Window& window, const WindowPoint& point, const WindowView& view, Written& at,
              PointLinear& linear, double& whitened_norm) {
  const bool anchored = window.anchored, own = anchored && view.keyframe == point.anchor;
  const ceres::CostFunction& cost = own ? *view.at_anchor : *view.cost;
  const double* motion = window.keyframe(view.keyframe).motion.data();
  const int rows = cost.num_residuals();
  std::array<const double*, 3> x{};
  std::array<double*, 3> J{};
  std::size_t n = 0;
  if (!own) x[n] = motion, J[n++] = at.by_view.data();
  if (anchored && !own) {
    x[n] = window.keyframe(point.anchor).motion.data();
    J[n++] = at.by_anchor.data();
  }
  x[n] = point.parameters.data(), J[n] = at.by_point.data();
  cost.Evaluate(x.data(), at.residual.data(), J.data());
  const double s = square(at, rows);
  whitened_norm = std::sqrt(s);
  double weight = 1;
  linear.cost += loss_at(window, s, weight);
  if (own) return add(rows, at, weight, window.sizes.motion(), nullptr, nullptr, linear);
  PointLinear::PoseBlock& pose_block =
      pose_block_of(view.keyframe, anchored ? 1 : 0, linear.pose_blocks);
  add(rows, at, weight, window.sizes.motion(), &pose_block,
      anchored ? &linear.pose_blocks.front() : nullptr, linear);
}

void add_alone(const WindowPoint& point, PointLinear& linear) {
  Eigen::RowVector3d J;
  double r = 0;
  const double* x = point.parameters.data();
  double* into = J.data();
  point.alone->Evaluate(&x, &r, &into);
  linear.V.noalias() += J.transpose() * J;
  linear.b += J.transpose() * r;
  linear.cost += r * r / 2;
}

void begin(const Window& window, const WindowPoint& point, PointLinear& linear) {
  linear.pose_blocks.clear();
  linear.V.setZero();
  linear.b.setZero();
  linear.cost = 0;
  linear.pose_blocks.reserve(point.views.size() + 1);
  if (window.anchored) linear.pose_blocks.push_back({.keyframe = point.anchor});
}

double evaluate(const Window& window, WindowPoint& point) {
  if (point.stale) {
    begin(window, point, point.linear);
    if (point.alone) add_alone(point, point.linear);
    point.linearised = 0;
    point.stale = false;
  }
  Written at;
  for (; point.linearised < point.views.size(); ++point.linearised) {
    WindowView& view = point.views[point.linearised];
    add_view(window, point, view, at, point.linear, view.whitened_norm);
  }
  return point.linear.cost;
}

void evaluate(const Window& window, ChainTerm& term) {
  using DenseRows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const int motion = window.sizes.motion(), additive = window.sizes.additive;
  const int errors = window.sizes.errors(), moved = errors - additive;
  const int rows = term.cost->num_residuals();
  std::vector<const double*> x;
  std::vector<DenseRows> J;
  for (int k = term.first; k < term.first + term.keyframes; ++k) {
    const WindowKeyframe& keyframe = window.keyframe(k);
    if (!term.additive_only) x.push_back(keyframe.motion.data()), J.emplace_back(rows, motion);
    if (additive > 0) x.push_back(keyframe.additive.data()), J.emplace_back(rows, additive);
  }
  std::vector<double*> into;
  for (DenseRows& j : J) into.push_back(j.data());
  term.residual.resize(rows);
  if (!term.cost->Evaluate(x.data(), term.residual.data(), into.data())) {
    // A cost that is NaN is never accepted.
    term.residual.setConstant(std::numeric_limits<double>::quiet_NaN());
    for (DenseRows& j : J) j.setZero();
  }
  term.jacobian.setZero(rows, errors * term.keyframes);
  auto block = J.begin();
  for (int column = 0; column < errors * term.keyframes; column += errors) {
    if (!term.additive_only) term.jacobian.middleCols(column, moved) = (block++)->leftCols(moved);
    if (additive > 0) term.jacobian.middleCols(column + moved, additive) = *block++;
  }
}

}  // namespace

PointLinear linearise(const Window& window, const WindowPoint& point, std::optional<int> keyframe) {
  PointLinear linear;
  Written at;
  double whitened_norm = 0;
  begin(window, point, linear);
  for (const WindowView& view : point.views) {
    if (keyframe && view.keyframe != *keyframe) continue;
    add_view(window, point, view, at, linear, whitened_norm);
  }
  if (point.alone && !keyframe) add_alone(point, linear);
  return linear;
}

Eigen::VectorXd residual(const Window& window, const WindowPoint& point, const WindowView& view) {
  const bool anchored = window.anchored, own = anchored && view.keyframe == point.anchor;
  const ceres::CostFunction& cost = own ? *view.at_anchor : *view.cost;
  std::array<const double*, 3> x{};
  std::size_t n = 0;
  if (!own) x[n++] = window.keyframe(view.keyframe).motion.data();
  if (anchored && !own) x[n++] = window.keyframe(point.anchor).motion.data();
  x[n] = point.parameters.data();
  Eigen::VectorXd result(cost.num_residuals());
  cost.Evaluate(x.data(), result.data(), nullptr);
  return result;
}

double evaluate(Window& window) {
  double cost = prior_cost(window);
  for (ChainTerm& term : window.terms) {
    if (window.stale || term.jacobian.size() == 0) evaluate(window, term);
    cost += term.residual.squaredNorm() / 2;
  }
  for (auto& [number, point] : window.points) {
    point.stale = point.stale || window.stale;
    cost += evaluate(window, point);
  }
  window.stale = false;
  return cost;
}

}  // namespace chasles::smooth_detail
