#include <algorithm>
#include <utility>

#include <chasles/filter/pixel_projection.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/smooth/terms/calibrated_costs_detail.hpp>

namespace chasles::smooth_detail {
namespace {

using RowMajorBlock =
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

// Writes the first columns of a block's Jacobian, and zeros behind.
void write_block(const Eigen::MatrixXd& d, int numbers, double* into) {
  if (into == nullptr) return;
  RowMajorBlock J(into, d.rows(), numbers);
  J.setZero();
  J.leftCols(d.cols()) = d;
}

int blocks_before_calibration(ViewForm form) {
  if (form == ViewForm::kAnchor) return 1;
  return form == ViewForm::kPoint ? 2 : 3;
}

}  // namespace

CalibrationCost::CalibrationCost(const Calibration& mean, const Eigen::MatrixXd& whitening)
    : blocks_(mean), mean_(static_cast<std::size_t>(blocks_.numbers())), whitening_(whitening) {
  smooth_detail::write_calibration(mean, mean_.data());
  set_num_residuals(blocks_.errors());
  for (const auto& block : blocks_.all()) mutable_parameter_block_sizes()->push_back(block.numbers);
}

bool CalibrationCost::Evaluate(const double* const* x, double* residuals,
                               double** jacobians) const {
  std::vector<double> numbers(mean_.size());
  for (std::size_t i = 0; i < blocks_.all().size(); ++i) {
    std::copy_n(x[i], blocks_.all()[i].numbers, numbers.begin() + blocks_.all()[i].number);
  }
  const Eigen::VectorXd e = difference(blocks_, numbers.data(), mean_.data());
  Eigen::Map<Eigen::VectorXd>(residuals, e.size()) = whitening_ * e;
  if (jacobians == nullptr) return true;
  for (std::size_t i = 0; i < blocks_.all().size(); ++i) {
    const auto& block = blocks_.all()[i];
    Eigen::MatrixXd d = whitening_.middleCols(block.row, block.errors);
    if (block.is_pose) d.leftCols<3>() *= so3::left_jacobian_inverse(e.segment<3>(block.row));
    write_block(d, block.numbers, jacobians[i]);
  }
  return true;
}

CorrectedStartCost::CorrectedStartCost(const BatchGraph& graph) : graph_(&graph) {
  set_num_residuals(15);
  *mutable_parameter_block_sizes() = {kMotionNumbers, 6,
                                      static_cast<int>(graph.start_by_imu.cols())};
}

bool CorrectedStartCost::Evaluate(const double* const* x, double* residuals,
                                  double** jacobians) const {
  if (!StartCost(*graph_).Evaluate(x, residuals, jacobians)) return false;
  const Eigen::Map<const Eigen::VectorXd> imu(x[2], graph_->start_by_imu.cols());
  const Eigen::MatrixXd by_imu = graph_->start_whitening * graph_->start_by_imu;
  Eigen::Map<Vector15d>{residuals} -= by_imu * (imu - graph_->imu_of_start);
  if (jacobians != nullptr) {
    write_block(-by_imu, static_cast<int>(by_imu.cols()), jacobians[2]);
  }
  return true;
}

CorrectedLinkCost::CorrectedLinkCost(const ImuLink& measured, const Eigen::Vector3d& gravity,
                                     const ImuCorrection& like)
    : measured_(&measured), gravity_(gravity), like_(like) {
  set_num_residuals(15);
  *mutable_parameter_block_sizes() = {kMotionNumbers, 6, kMotionNumbers, 6, like.size()};
}

bool CorrectedLinkCost::Evaluate(const double* const* x, double* residuals,
                                 double** jacobians) const {
  const ImuCorrection imu = read_imu(x[4], like_);
  const ImuLink link = corrected(imu, *measured_);
  if (!LinkCost(link, gravity_).Evaluate(x, residuals, jacobians)) return false;
  if (jacobians != nullptr && jacobians[4] != nullptr) {
    const LinkByImu d =
        link_by_imu(*measured_, imu, read_state(x[0], x[1]), read_state(x[2], x[3]));
    write_block(d, imu.size(), jacobians[4]);
  }
  return true;
}

std::unique_ptr<ceres::CostFunction> start_cost(const BatchGraph& graph) {
  if (graph.start_by_imu.size() > 0) return std::make_unique<CorrectedStartCost>(graph);
  return std::make_unique<StartCost>(graph);
}

std::unique_ptr<ceres::CostFunction> link_cost(const BatchGraph& graph, const ImuLink& link) {
  if (const ImuCorrection* imu = graph.imu()) {
    return std::make_unique<CorrectedLinkCost>(link, graph.gravity, *imu);
  }
  return std::make_unique<LinkCost>(link, graph.gravity);
}

EstimatedCamera::EstimatedCamera(const Camera& known, int index, const Calibration& calibration,
                                 double used_time_offset)
    : camera(known), has_extrinsics(!calibration.imu_T_camera.empty()) {
  if (calibration.time_offset) time_offset = used_time_offset;
  if (!calibration.intrinsics.empty()) {
    intrinsics = calibration.intrinsics[static_cast<std::size_t>(index)];
  }
}

CalibratedTerm calibrated_term(const InertialBatchInput& input, const BatchGraph& graph,
                               const PointView& view, const SE3& of_anchor, double sigma) {
  const BatchKeyframe& keyframe = graph.keyframes[static_cast<std::size_t>(view.keyframe)];
  return {.camera = {input.cameras[static_cast<std::size_t>(view.camera)], view.camera,
                     *graph.calibration, to_seconds(input.time_offset)},
          .motion = motion_of(graph, keyframe),
          .of_anchor = of_anchor,
          .pixel = view.pixel,
          .sigma = sigma};
}

struct CalibratedCost::At {
  Camera camera;          // at the line of the pixel
  Intrinsics intrinsics;  // if they are estimated
  double delay = 0;       // of that line after the keyframe [s]
  SE3 imu_T_line;
};

CalibratedCost::CalibratedCost(CalibratedTerm term, ViewForm form)
    : term_(std::move(term)), form_(form) {
  set_num_residuals(2);
  std::vector<int>& sizes = *mutable_parameter_block_sizes();
  if (form != ViewForm::kAnchor) sizes.push_back(kMotionNumbers);
  if (form == ViewForm::kAnchored) sizes.push_back(kMotionNumbers);
  sizes.push_back(3);
  if (term_.camera.has_extrinsics) sizes.push_back(kPoseNumbers);
  if (term_.camera.time_offset) sizes.push_back(1);
  if (term_.camera.intrinsics) sizes.push_back(6 * term_.camera.intrinsics->blocks());
  if (term_.anchor && !term_.anchor->is_view) sizes.push_back(kPoseNumbers);
}

// `calibration`: the blocks of it, the view's extrinsics first.
Landmark CalibratedCost::anchored(const double* parameters,
                                  const double* const* calibration) const {
  Landmark landmark;
  landmark.anchor = 0;
  landmark.inverse_depth = Eigen::Map<const Eigen::Vector3d>(parameters);
  landmark.cam_T_imu = term_.of_anchor;
  if (!term_.anchor) return landmark;
  const std::size_t last = parameter_block_sizes().size() - blocks_before_calibration(form_) - 1;
  landmark.cam_T_imu =
      term_.anchor->axes_T_imu(read_pose(calibration[term_.anchor->is_view ? 0 : last]));
  landmark.imu_T_line = term_.anchor->imu_T_line;
  return landmark;
}

CalibratedCost::At CalibratedCost::at(const double* const* calibration) const {
  const EstimatedCamera& of = term_.camera;
  At at{.camera = of.camera, .intrinsics = {}, .delay = 0, .imu_T_line = {}};
  if (of.has_extrinsics) at.camera.cam_T_imu = read_pose(*calibration++).inverse();
  if (of.time_offset) at.delay = **calibration++ - *of.time_offset;
  if (of.intrinsics) {
    at.intrinsics = read_intrinsics(*calibration, *of.intrinsics);
    at.camera = with_intrinsics(at.camera, at.intrinsics);
  }
  at.delay += line_delay(at.camera, term_.pixel);
  at.imu_T_line = term_.motion.after(at.delay);
  at.camera.cam_T_imu = at.camera.cam_T_imu * at.imu_T_line.inverse();
  return at;
}

bool CalibratedCost::Evaluate(const double* const* x, double* residuals, double** jacobians) const {
  const int own = blocks_before_calibration(form_);
  const At at = this->at(x + own);
  const SE3 world_T_imu = form_ == ViewForm::kAnchor ? SE3{} : read_pose(x[0]);
  const Eigen::Map<const Eigen::Vector3d> parameters(x[own - 1]);
  Clone anchor;
  Landmark landmark;
  HomogeneousPoint point{.p_world = parameters, .w = 1};
  if (form_ != ViewForm::kPoint) {
    if (form_ == ViewForm::kAnchored) anchor.world_T_imu = read_pose(x[1]);
    landmark = anchored(x[own - 1], x + own);
    point = homogeneous(anchor, landmark);
  }
  const auto seen = see(at.camera, world_T_imu, point, term_.pixel, term_.least_depth);
  if (!seen) {
    std::fill_n(residuals, 2, kNotSeen);
    for (std::size_t i = 0; jacobians != nullptr && i < parameter_block_sizes().size(); ++i) {
      if (jacobians[i] != nullptr) std::fill_n(jacobians[i], 2 * parameter_block_sizes()[i], 0.0);
    }
    return true;
  }
  Eigen::Map<Eigen::Vector2d>{residuals} = -seen->residual / term_.sigma;
  if (jacobians == nullptr) return true;
  if (form_ != ViewForm::kAnchor)
    write_block(seen->d_pose / term_.sigma, kMotionNumbers, jacobians[0]);
  Eigen::Matrix<double, 2, 3> by_parameters = seen->d_point;
  Matrix26d by_anchor = Matrix26d::Zero();
  if (form_ != ViewForm::kPoint) {
    const Eigen::Matrix<double, 2, 9> d = seen->d_point * homogeneous_derivative(anchor, landmark);
    by_parameters = d.rightCols<3>();
    by_parameters.rightCols<1>() += seen->d_w;
    if (term_.anchor)
      by_anchor = seen->d_point * homogeneous_derivative_by_camera(anchor, landmark);
    if (form_ == ViewForm::kAnchored) {
      write_block(d.leftCols<6>() / term_.sigma, kMotionNumbers, jacobians[1]);
    }
  }
  write_block(by_parameters / term_.sigma, 3, jacobians[own - 1]);
  write_calibration(at, world_T_imu, point, *seen, by_anchor, jacobians + own);
  return true;
}

void CalibratedCost::write_calibration(const At& at, const SE3& world_T_imu,
                                       const HomogeneousPoint& point, const Seen& seen,
                                       const Matrix26d& by_anchor, double** jacobians) const {
  const EstimatedCamera& of = term_.camera;
  const Eigen::Vector3d p_cam = in_camera(at.camera, world_T_imu, point);
  if (of.has_extrinsics) {
    Matrix26d d = derivative_by_camera(at.camera, world_T_imu, point, seen.d_point, at.imu_T_line);
    if (term_.anchor && term_.anchor->is_view) d += by_anchor;
    write_block(d / term_.sigma, kPoseNumbers, *jacobians++);
  }
  if (of.time_offset) {
    const Eigen::Vector3d moved = moved_by_delay(at.camera, term_.motion, at.delay, p_cam, point.w);
    const Eigen::Vector3d moved_world = world_T_imu.R * (at.camera.cam_T_imu.R.transpose() * moved);
    write_block(seen.d_point * moved_world / term_.sigma, 1, *jacobians++);
  }
  if (of.intrinsics) {
    const auto by = intrinsics_derivative(at.intrinsics, at.camera, term_.motion, at.delay,
                                          term_.pixel, p_cam, point.w);
    write_block(by.d.leftCols(6 * by.blocks) / term_.sigma, 6 * by.blocks, *jacobians++);
  }
  if (term_.anchor && !term_.anchor->is_view) {
    write_block(by_anchor / term_.sigma, kPoseNumbers, *jacobians);
  }
}

}  // namespace chasles::smooth_detail
