#include <cmath>

#include <chasles/lie/so3.hpp>
#include <chasles/smooth/window/window_pixels_detail.hpp>

namespace chasles::smooth_detail {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// By the whole point of the world, times w.
struct Sums {
  Matrix3d N = Matrix3d::Zero();  // second derivative
  Matrix3d X = Matrix3d::Zero();  // with the landmark's parameters
  Vector3d n = Vector3d::Zero();  // gradient

  void add(const Sums& more) {
    N += more.N;
    X += more.X;
    n += more.n;
  }
};

// [s]x M.
template <int Columns>
Eigen::Matrix<double, 3, Columns> cross(const Vector3d& s,
                                        const Eigen::Matrix<double, 3, Columns>& M) {
  Eigen::Matrix<double, 3, Columns> product;
  for (int i = 0; i < Columns; ++i) product.col(i) = s.cross(M.col(i));
  return product;
}

// A_s^T N A_t for a symmetric N, where A_s = ([s]x, -w I) is the point's derivative by a pose.
// `by_s`: [s]x N, and by_t.
Matrix6d between(const Vector3d& s, const Matrix3d& by_s, const Matrix3d& N, const Matrix3d& by_t,
                 double w) {
  Matrix6d H;
  H.topLeftCorner<3, 3>() = cross<3>(s, by_t.transpose());
  H.topRightCorner<3, 3>() = w * by_s;
  H.bottomLeftCorner<3, 3>() = w * by_t.transpose();
  H.bottomRightCorner<3, 3>() = w * w * N;
  return H;
}

// A^T B.
template <int Columns>
Eigen::Matrix<double, 6, Columns> by_pose(const Vector3d& s, double w,
                                          const Eigen::Matrix<double, 3, Columns>& B) {
  Eigen::Matrix<double, 6, Columns> product;
  product << -cross<Columns>(s, B), -w * B;
  return product;
}

// Value and slope of the loss: the slope weights the squares (iteratively reweighted least
// squares).
struct Loss {
  double value, slope;
};

Loss loss_at(const Window& window, double square) {
  if (!window.loss) return {.value = square / 2, .slope = 1};
  std::array<double, 3> rho{};
  window.loss->Evaluate(square, rho.data());
  return {.value = rho[0] / 2, .slope = rho[1]};
}

}  // namespace

PixelViews::PixelViews(const Window& window, const WindowPoint& point)
    : window_(&window), own_(window.anchored ? point.anchor : -1) {
  if (!window.anchored) {
    at_ = {.p_world = point.parameters, .w = 1};
    return;
  }
  const Clone anchor = clone_of(window, point.anchor);
  const Landmark landmark = landmark_of(point);
  at_ = homogeneous(anchor, landmark);
  by_parameters_ = homogeneous_derivative(anchor, landmark).rightCols<3>();
  from_anchor_ = at_.p_world - at_.w * anchor.world_T_imu.p;
}

std::optional<Seen> PixelViews::see(const WindowView& view) const {
  // The anchor's own view does not depend on its pose.
  const SE3 world_T_imu = read_pose(window_->keyframe(view.keyframe).motion.data());
  const PixelTerm& term = *view.pixel;
  return chasles::see(*term.camera, term.cam_T_imu, world_T_imu, at_, term.pixel, term.least_depth);
}

Eigen::Vector2d PixelViews::residual(const WindowView& view) const {
  const auto seen = see(view);
  if (!seen) return Eigen::Vector2d::Constant(kNotSeen);
  return -seen->residual / view.pixel->sigma;
}

void PixelViews::add(std::span<WindowView> views, PointLinear& linear) const {
  Sums all;
  for (std::size_t i = 0; i < views.size();) {
    const int keyframe = views[i].keyframe;
    Sums sums;
    for (; i < views.size() && views[i].keyframe == keyframe; ++i) {
      WindowView& view = views[i];
      const auto seen = see(view);
      const double inverse = 1 / view.pixel->sigma;
      const double square =
          seen ? (inverse * seen->residual).squaredNorm() : 2 * kNotSeen * kNotSeen;
      view.whitened_norm = std::sqrt(square);
      const Loss loss = loss_at(*window_, square);
      linear.cost += loss.value;
      if (!seen) continue;
      const double weight = loss.slope * inverse * inverse;
      Eigen::Matrix<double, 2, 3> by_point = seen->d_point;
      if (window_->anchored) {
        by_point = seen->d_point * by_parameters_;
        by_point.col(2) += seen->d_w;
      }
      const Eigen::Matrix<double, 3, 2> weighted = weight * by_point.transpose();
      linear.V.noalias() += weighted * by_point;
      linear.b.noalias() -= weighted * seen->residual;
      if (keyframe == own_) continue;
      const Eigen::Matrix<double, 3, 2> Dt = weight * seen->d_point.transpose();
      sums.N.noalias() += Dt * seen->d_point;
      sums.X.noalias() += Dt * by_point;
      sums.n.noalias() -= Dt * seen->residual;
    }
    if (keyframe == own_) continue;
    const double w = at_.w;
    const Vector3d s = at_.p_world - w * read_pose(window_->keyframe(keyframe).motion.data()).p;
    PointLinear::PoseBlock& block = linear.pose_block_of(keyframe, window_->anchored);
    const Matrix3d by_s = cross<3>(s, sums.N);
    block.H += between(s, by_s, sums.N, by_s, w);
    block.W += by_pose(s, w, sums.X);
    block.g += by_pose(s, w, sums.n);
    if (!window_->anchored) continue;
    block.by_anchor -= between(s, by_s, sums.N, cross<3>(from_anchor_, sums.N), w);
    all.add(sums);
  }
  if (!window_->anchored) return;
  PointLinear::PoseBlock& anchor = linear.pose_blocks.front();
  const Matrix3d by_anchor = cross<3>(from_anchor_, all.N);
  anchor.H += between(from_anchor_, by_anchor, all.N, by_anchor, at_.w);
  anchor.W -= by_pose(from_anchor_, at_.w, all.X);
  anchor.g -= by_pose(from_anchor_, at_.w, all.n);
}

}  // namespace chasles::smooth_detail
