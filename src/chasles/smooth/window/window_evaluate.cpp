#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <chasles/smooth/window/window_pixels_detail.hpp>

// The terms of a window and their derivatives at the present values.
namespace chasles::smooth_detail {
namespace {

constexpr int kMostRows = 4;
// Of the calibration: extrinsics, time offset, intrinsics, and the extrinsics of an anchor.
constexpr int kMostBlocks = 4;
constexpr int kMostNumbers = 6 * IntrinsicsDerivative::kMostBlocks;  // of one of them

template <int Rows, int Columns>
using Rowwise = Eigen::Map<const Eigen::Matrix<double, Rows, Columns, Eigen::RowMajor>, 0,
                           Eigen::OuterStride<>>;

// A view's residual and its derivatives as written by a cost function.
struct Written {
  std::array<double, kMostRows> residual;
  std::array<double, kMostRows * kMotionNumbers> by_view, by_anchor;
  std::array<double, 3 * kMostRows> by_point;
  // Of pixels, whose cameras may be estimated; in the order of Window::camera_blocks.
  std::array<std::array<double, 2 * kMostNumbers>, kMostBlocks> by_calibration;
};

// The blocks on which a view depends, and what it writes.
struct ViewBlocks {
  std::array<const double*, 3 + kMostBlocks> x;
  std::array<double*, 3 + kMostBlocks> J;
  std::size_t count = 0;

  void add(const double* numbers, double* derivative) {
    x[count] = numbers;
    J[count++] = derivative;
  }
};

template <int Rows>
void add(const Written& at, double weight, int width, PointLinear::PoseBlock* view,
         PointLinear::PoseBlock* anchor, PointLinear& linear) {
  const Eigen::Map<const Eigen::Matrix<double, Rows, 1>> r(at.residual.data());
  const Eigen::Matrix<double, Rows, 3> P =
      Rowwise<Rows, 3>(at.by_point.data(), Eigen::OuterStride<>(3));
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

bool is_of_anchor(const Window& window, const WindowPoint& point, const WindowView& view) {
  return window.anchored && view.keyframe == point.anchor;
}

// Of the calibration, those on which a view depends.
struct OwnBlocks {
  std::array<std::size_t, kMostBlocks> of;
  std::size_t count = 0;
};

OwnBlocks calibration_of(const Window& window, const WindowPoint& point, const WindowView& view) {
  OwnBlocks own;
  if (window.camera_blocks.empty()) return own;
  for (const std::size_t block : window.camera_blocks[static_cast<std::size_t>(view.camera)]) {
    own.of[own.count++] = block;
  }
  if (point.camera && own.of[0] != point.extrinsics) own.of[own.count++] = point.extrinsics;
  return own;
}

ViewBlocks blocks_of(const Window& window, const WindowPoint& point, const WindowView& view,
                     const OwnBlocks& calibration, Written& at) {
  const bool own = is_of_anchor(window, point, view);
  ViewBlocks blocks;
  if (!own) blocks.add(window.keyframe(view.keyframe).motion.data(), at.by_view.data());
  if (window.anchored && !own) {
    blocks.add(window.keyframe(point.anchor).motion.data(), at.by_anchor.data());
  }
  blocks.add(point.parameters.data(), at.by_point.data());
  for (std::size_t i = 0; i < calibration.count; ++i) {
    const auto& block = window.sizes.calibration.all()[calibration.of[i]];
    blocks.add(window.calibration.data() + block.number, at.by_calibration[i].data());
  }
  return blocks;
}

// A derivative of a pixel by a block of the calibration.
using ByCalibration = Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMostNumbers>;

// Adds J^T K of a pose's derivative J and that by a block of the calibration, which begins at row.
void add_pose_by_calibration(const std::array<double, kMostRows * kMotionNumbers>& by_pose,
                             int width, const ByCalibration& K, int row,
                             Eigen::Matrix<double, 6, Eigen::Dynamic>& sum) {
  const Eigen::Matrix<double, 2, 6> J = Rowwise<2, 6>(by_pose.data(), Eigen::OuterStride<>(width));
  sum.middleCols(row, K.cols()).noalias() += J.transpose() * K;
}

// `is_own`: the anchor's view of its landmark, which depends on no pose. That of others is the last
// pose block.
void add_calibration(const Window& window, const OwnBlocks& own, const Written& at, double weight,
                     bool is_own, PointLinear& linear) {
  const Eigen::Map<const Eigen::Vector2d> r(at.residual.data());
  const Rowwise<2, 3> P(at.by_point.data(), Eigen::OuterStride<>(3));
  const auto& all = window.sizes.calibration.all();
  const int width = window.sizes.motion(), errors = window.sizes.calibration.errors();
  std::vector<Eigen::Matrix<double, 6, Eigen::Dynamic>>& by_pose = linear.calibration.by_pose;
  while (by_pose.size() < linear.pose_blocks.size()) by_pose.emplace_back().setZero(6, errors);
  std::array<ByCalibration, kMostBlocks> d;
  for (std::size_t i = 0; i < own.count; ++i) {
    const auto& block = all[own.of[i]];
    d[i] = Rowwise<2, Eigen::Dynamic>(at.by_calibration[i].data(), 2, block.errors,
                                      Eigen::OuterStride<>(block.numbers));
  }
  for (std::size_t i = 0; i < own.count; ++i) {
    const int row = all[own.of[i]].row;
    const ByCalibration K = weight * d[i];
    const auto n = K.cols();
    for (std::size_t j = 0; j < own.count; ++j) {
      linear.calibration.H.block(row, all[own.of[j]].row, n, d[j].cols()).noalias() +=
          K.transpose() * d[j];
    }
    linear.calibration.W.middleRows(row, n).noalias() += K.transpose() * P;
    linear.calibration.g.segment(row, n).noalias() += K.transpose() * r;
    if (is_own) continue;
    add_pose_by_calibration(at.by_view, width, K, row, by_pose.back());
    if (window.anchored) add_pose_by_calibration(at.by_anchor, width, K, row, by_pose.front());
  }
}

void add_view(const Window& window, const WindowPoint& point, WindowView& view,
              PointLinear& linear) {
  Written at;
  const bool anchored = window.anchored, own = is_of_anchor(window, point, view);
  const ceres::CostFunction& cost = own ? *view.at_anchor : *view.cost;
  const int rows = cost.num_residuals();
  const OwnBlocks calibration = calibration_of(window, point, view);
  ViewBlocks blocks = blocks_of(window, point, view, calibration, at);
  cost.Evaluate(blocks.x.data(), at.residual.data(), blocks.J.data());
  const double s = square(at, rows);
  view.whitened_norm = std::sqrt(s);
  double weight = 1;
  linear.cost += loss_at(window, s, weight);
  if (own) {
    add(rows, at, weight, window.sizes.motion(), nullptr, nullptr, linear);
  } else {
    PointLinear::PoseBlock& pose_block = linear.pose_block_of(view.keyframe, anchored);
    add(rows, at, weight, window.sizes.motion(), &pose_block,
        anchored ? &linear.pose_blocks.front() : nullptr, linear);
  }
  if (calibration.count > 0) add_calibration(window, calibration, at, weight, own, linear);
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
  const int errors = window.sizes.calibration.errors();
  if (errors == 0) return;
  linear.calibration.H.setZero(errors, errors);
  linear.calibration.W.setZero(errors, 3);
  linear.calibration.g.setZero(errors);
  linear.calibration.by_pose.clear();
}

// The views of a landmark are all of one kind.
void add_views(const Window& window, const WindowPoint& point, std::span<WindowView> views,
               PointLinear& linear) {
  if (views.empty()) return;
  if (views.front().pixel) return PixelViews(window, point).add(views, linear);
  for (WindowView& view : views) add_view(window, point, view, linear);
}

double evaluate(const Window& window, WindowPoint& point) {
  if (!point.stale && point.linearised == point.views.size()) return point.linear.cost;
  if (point.stale) {
    begin(window, point, point.linear);
    if (point.alone) add_alone(point, point.linear);
    point.linearised = 0;
    point.stale = false;
  }
  add_views(window, point, std::span(point.views).subspan(point.linearised), point.linear);
  point.linearised = point.views.size();
  point.linear.V_inverse = inverse_on_range(point.linear.V);
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
  if (term.calibration) {
    x.push_back(window.calibration.data() + term.calibration->number);
    J.emplace_back(rows, term.calibration->numbers);
  }
  std::vector<double*> into;
  for (DenseRows& j : J) into.push_back(j.data());
  term.residual.resize(rows);
  if (!term.cost->Evaluate(x.data(), term.residual.data(), into.data())) {
    // A cost that is NaN is never accepted.
    term.residual.setConstant(std::numeric_limits<double>::quiet_NaN());
    for (DenseRows& j : J) j.setZero();
  }
  const int of_calibration = term.calibration ? term.calibration->errors : 0;
  term.jacobian.setZero(rows, errors * term.keyframes + of_calibration);
  auto block = J.begin();
  for (int column = 0; column < errors * term.keyframes; column += errors) {
    if (!term.additive_only) term.jacobian.middleCols(column, moved) = (block++)->leftCols(moved);
    if (additive > 0) term.jacobian.middleCols(column + moved, additive) = *block++;
  }
  if (term.calibration) term.jacobian.rightCols(of_calibration) = block->leftCols(of_calibration);
}

}  // namespace

PointLinear linearise(const Window& window, WindowPoint& point, std::optional<int> keyframe) {
  PointLinear linear;
  begin(window, point, linear);
  std::span<WindowView> views = point.views;
  if (keyframe) {
    // Not equal_range: Clang 14 cannot compile the subrange of libstdc++ 12.
    const auto of = [](const WindowView& view) { return view.keyframe; };
    views = {std::ranges::lower_bound(views, *keyframe, {}, of),
             std::ranges::upper_bound(views, *keyframe, {}, of)};
  }
  add_views(window, point, views, linear);
  if (point.alone && !keyframe) add_alone(point, linear);
  return linear;
}

Eigen::VectorXd residual(const Window& window, const WindowPoint& point, const WindowView& view) {
  if (view.pixel) return PixelViews(window, point).residual(view);
  const ceres::CostFunction& cost =
      is_of_anchor(window, point, view) ? *view.at_anchor : *view.cost;
  Written unused;
  Eigen::VectorXd result(cost.num_residuals());
  const OwnBlocks calibration = calibration_of(window, point, view);
  cost.Evaluate(blocks_of(window, point, view, calibration, unused).x.data(), result.data(),
                nullptr);
  return result;
}

double evaluate(Window& window) {
  if (window.stale || !window.prior.present) evaluate_prior(window);
  double cost = 0;
  for (ChainTerm& term : window.terms) {
    if (window.stale || term.jacobian.size() == 0) evaluate(window, term);
    cost += term.residual.squaredNorm() / 2;
  }
  for (auto& [number, point] : window.points) {
    point.stale = point.stale || window.stale;
    cost += evaluate(window, point);
  }
  window.stale = false;
  return cost + prior_cost(window);
}

}  // namespace chasles::smooth_detail
