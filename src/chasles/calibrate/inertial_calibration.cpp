#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/base/median.hpp>
#include <chasles/calibrate/chain_equations.hpp>
#include <chasles/calibrate/corner_loss.hpp>
#include <chasles/calibrate/inertial_calibration.hpp>
#include <chasles/calibrate/levenberg_marquardt.hpp>
#include <chasles/calibrate/rotation_alignment.hpp>
#include <chasles/imu/imu_buffer.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/smooth/terms/imu_link.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix32d = Eigen::Matrix<double, 3, 2>;

constexpr double kLongestLink = 1;        // without views the chain is cut [s]
constexpr double kMostUnexplained = 0.3;  // of the rates, for a first alignment
constexpr double kMostForce = 0.2;        // relative error of its mean
constexpr double kMostScaleSigmas = 10;   // of a scale, in its sigmas before any view
constexpr double kStale = 0.0005;         // change of an offset after which links begin anew [s]
// Of the first state and of the parameters, before any view.
constexpr double kAccelerometerBiasSigma = 0.5, kGyroscopeBiasSigma = 0.1, kVelocitySigma = 10;
constexpr double kScaleSigma = 0.005, kMisalignmentSigma = 0.002;
constexpr double kOffsetSigma = 1, kReadoutSigma = 0.02;

struct InertialInstant {
  Time time{};  // of the state, IMU's clock
  std::vector<const TargetView*> views;
  ImuSample sample;                         // at that time, as measured
  Vector3d rate_change = Vector3d::Zero();  // half of it, while lines are read [rad/s^2]
};

struct InertialRig {
  std::vector<Camera> cameras;
  std::vector<double> offsets;
  Vector3d gravity = Vector3d::Zero();  // in the target's frame
  ImuCorrection imu = {};
  VectorXd shape;
  std::vector<InertialState> states;  // of each instant; world: the target's frame
};

// Two directions across gravity in which it turns.
Matrix32d across(const Vector3d& gravity) {
  Matrix32d E;
  E.col(0) = gravity.unitOrthogonal();
  E.col(1) = gravity.normalized().cross(E.col(0));
  return E;
}

void move(SE3& pose, const Vector6d& d) {
  pose = {so3::normalized(so3::exp(d.head<3>()) * pose.R), pose.p + d.tail<3>()};
}

std::vector<int> columns_from(int first, int count) {
  std::vector<int> columns(static_cast<std::size_t>(count));
  std::iota(columns.begin(), columns.end(), first);
  return columns;
}

struct Linearised {
  ChainEquations equations;
  double cost = 0;
  std::optional<ChainEquations::Step> solve(double damping) const {
    return equations.solve(damping);
  }
};

// The motion of the IMU just after the time of a state.
struct Motion {
  Vector3d rate, acceleration;
  SE3 world_T_imu;  // then
  Vector3d v_world;
  double delay = 0;

  Motion(const InertialState& x, const InertialRig& rig, const InertialInstant& at, double seconds)
      : acceleration(rig.gravity), delay(seconds) {
    const ImuSample sample = corrected(rig.imu, at.sample);
    const Vector3d now = sample.angular_rate_imu - x.gyroscope_bias;
    rate = now + 2 * seconds * at.rate_change;
    acceleration += x.world_T_imu.R * (sample.specific_force_imu - x.accelerometer_bias);
    v_world = x.v_world + seconds * acceleration;
    world_T_imu.R = x.world_T_imu.R * so3::exp(seconds * now + seconds * seconds * at.rate_change);
    world_T_imu.p = x.world_T_imu.p + seconds * x.v_world + seconds * seconds / 2 * acceleration;
  }
};

class InertialProblem {
 public:
  InertialProblem(const InertialCalibrationInput& input, const InertialLayout& layout,
                  std::vector<InertialInstant> instants, double pixel_sigma)
      : input_(input), layout_(layout), instants_(std::move(instants)), sigma_(pixel_sigma) {}

  const std::vector<InertialInstant>& instants() const { return instants_; }
  void set_sigma(double sigma) { sigma_ = sigma; }
  void set_instants(std::vector<InertialInstant> instants) { instants_ = std::move(instants); }

  // The samples between the instants as links, at the biases of the states.
  void make_links(const InertialRig& x, double gyroscope_factor, double accelerometer_factor) {
    ImuBuffer buffer({.convention = input_.convention});
    for (const ImuSample& sample : input_.imu) buffer.add(sample);
    ImuNoise noise = input_.noise;
    noise.gyroscope_noise_density *= gyroscope_factor;
    noise.gyroscope_random_walk *= gyroscope_factor;
    noise.accelerometer_noise_density *= accelerometer_factor;
    noise.accelerometer_random_walk *= accelerometer_factor;
    links_.assign(instants_.size(), std::nullopt);
    for (std::size_t k = 0; k < instants_.size(); ++k) {
      constexpr double kAhead = 0.02;  // as long as a readout [s]
      const Time ahead = instants_[k].time + Time(static_cast<std::int64_t>(1e9 * kAhead));
      instants_[k].sample = buffer.at(instants_[k].time).value();
      instants_[k].rate_change =
          (buffer.at(ahead)->angular_rate_imu - instants_[k].sample.angular_rate_imu) /
          (2 * kAhead);
      if (k + 1 == instants_.size()) break;
      if (to_seconds(instants_[k + 1].time - instants_[k].time) > kLongestLink) continue;
      links_[k] = imu_link(buffer.between(instants_[k].time, instants_[k + 1].time),
                           x.states[k].biases(), noise);
    }
  }

  std::optional<Linearised> linearised(const InertialRig& x) const {
    Linearised result{{instants_.size(), 15, layout_.rows()}, 0};
    for (std::size_t k = 0; k < instants_.size(); ++k) {
      for (const TargetView* view : instants_[k].views) {
        if (!add_view(x, k, *view, result)) return std::nullopt;
      }
      const bool begins = k == 0 || !links_[k - 1];
      if (begins) add_first(x, k, result);
      if (links_[k]) add_link(x, k, result);
    }
    add_priors(x, result);
    return result;
  }

  // The pixels alone, as if the poses were free.
  std::optional<Linearised> pixels_alone(const InertialRig& x) const {
    Linearised result{{instants_.size(), 15, layout_.rows()}, 0};
    const MatrixXd none(15, 0);
    for (std::size_t k = 0; k < instants_.size(); ++k) {
      for (const TargetView* view : instants_[k].views) {
        if (!add_view(x, k, *view, result)) return std::nullopt;
      }
      result.equations.add(k, 1e-3 * MatrixXd::Identity(15, 15), none, {}, VectorXd::Zero(15));
    }
    result.equations.add_border(1e-6 * MatrixXd::Identity(layout_.rows(), layout_.rows()),
                                columns_from(0, layout_.rows()), VectorXd::Zero(layout_.rows()));
    return result;
  }

  std::optional<InertialRig> moved(const InertialRig& x, const ChainEquations::Step& step) const {
    InertialRig next = x;
    const VectorXd& d = step.border;
    for (std::size_t c = 0; c < layout_.cameras(); ++c) {
      const auto camera = chasles::moved(
          x.cameras[c], d.segment(layout_.lens_row(c), layout_.lens(c).parameters()));
      if (!camera) return std::nullopt;
      next.cameras[c] = *camera;
      move(next.cameras[c].cam_T_imu, d.segment<6>(layout_.pose_row(c)));
      next.offsets[c] += d[layout_.offset_row(c)];
      if (layout_.has_readout()) next.cameras[c].shutter.readout += d[layout_.readout_row(c)];
    }
    next.gravity = so3::exp(across(x.gravity) * d.segment<2>(layout_.gravity_row())) * x.gravity;
    if (x.imu.size() > 0) next.imu.add(d.segment(layout_.imu_row(), x.imu.size()));
    next.shape += d.tail(layout_.shape_rows());
    for (std::size_t k = 0; k < x.states.size(); ++k) {
      InertialState& state = next.states[k];
      move(state.world_T_imu, step.blocks[k].head<6>());
      state.v_world += step.blocks[k].segment<3>(6);
      state.accelerometer_bias += step.blocks[k].segment<3>(9);
      state.gyroscope_bias += step.blocks[k].segment<3>(12);
    }
    return next;
  }

  // Measured minus projected, at the lines of the corners. Empty where a corner has no pixel.
  std::vector<Vector2d> errors(const InertialRig& x, std::size_t k, const TargetView& view) const {
    std::vector<Vector2d> result;
    const auto c = static_cast<std::size_t>(view.camera);
    for (std::size_t i = 0; i < view.ids.size(); ++i) {
      const Motion motion(x.states[k], x, instants_[k], delay(x, k, view, view.pixels[i]));
      const Vector3d p_imu = motion.world_T_imu.inverse() * corner(x, view.ids[i]);
      const auto image = project(x.cameras[c], x.cameras[c].cam_T_imu * p_imu);
      if (!image) return {};
      result.push_back(view.pixels[i] - image->pixel);
    }
    return result;
  }

  // Mean squares of the whitened residuals of rotation, and of position and velocity.
  std::pair<double, double> link_squares(const InertialRig& x) const {
    double rotation = 0, motion = 0, links = 0;
    for (std::size_t k = 0; k < links_.size(); ++k) {
      if (!links_[k]) continue;
      const Vector15d r = link_residual(chasles::corrected(x.imu, *links_[k]), x.states[k],
                                        x.states[k + 1], x.gravity);
      // W is lower triangular: the first rows are of the rotation alone.
      rotation += r.head<3>().squaredNorm() / 3;
      motion += r.segment<6>(3).squaredNorm() / 6;
      ++links;
    }
    return {rotation / std::max(1.0, links), motion / std::max(1.0, links)};
  }

 private:
  Vector3d corner(const InertialRig& x, int id) const {
    const auto i = static_cast<std::size_t>(id);
    const Vector3d& drawn = input_.cameras.corners[i];
    if (x.shape.size() == 0) return drawn;
    return drawn + input_.cameras.shape.by_parameters[i] * x.shape;
  }

  // From the time of the state until the line of a pixel.
  double delay(const InertialRig& x, std::size_t k, const TargetView& view,
               const Vector2d& pixel) const {
    const auto c = static_cast<std::size_t>(view.camera);
    return to_seconds(view.time - instants_[k].time) + x.offsets[c] +
           x.cameras[c].shutter.readout * line_part(x.cameras[c], pixel);
  }

  bool add_view(const InertialRig& x, std::size_t k, const TargetView& view,
                Linearised& result) const {
    const auto c = static_cast<std::size_t>(view.camera);
    const Camera& camera = x.cameras[c];
    const int lens = layout_.lens(c).parameters(), shape = layout_.shape_rows();
    const int of_camera = lens + 7 + (layout_.has_readout() ? 1 : 0), border = of_camera + shape;
    const MatrixXd by_coordinates = by_search_coordinates(
        layout_.lens(c), search_coordinates(layout_.lens(c), lens_parameters(camera)));
    const Matrix3d& R = x.states[k].world_T_imu.R;
    const auto rows = 2 * static_cast<Eigen::Index>(view.ids.size());
    MatrixXd by_state = MatrixXd::Zero(rows, 15), by_border(rows, border);
    VectorXd r(rows);
    for (std::size_t i = 0; i < view.ids.size(); ++i) {
      const Motion motion(x.states[k], x, instants_[k], delay(x, k, view, view.pixels[i]));
      const Vector3d arm = corner(x, view.ids[i]) - motion.world_T_imu.p;
      const Matrix3d imu_R_world = motion.world_T_imu.R.transpose();
      const Vector3d p_imu = imu_R_world * arm;
      const Vector3d turned = camera.cam_T_imu.R * p_imu, p_cam = turned + camera.cam_T_imu.p;
      const auto image = project(camera, p_cam);
      if (!image) return false;
      const auto row = 2 * static_cast<Eigen::Index>(i);
      const Vector2d error = (image->pixel - view.pixels[i]) / sigma_;
      const WeightedCorner w = weighted_corner(error.norm());
      const double factor = w.root_weight / sigma_;
      const Eigen::Matrix<double, 2, 3> by_imu = factor * image->d_point * camera.cam_T_imu.R;
      const Eigen::Matrix<double, 2, 3> by_world = by_imu * imu_R_world;
      by_state.block<2, 3>(row, 0) = by_world * hat(arm);
      by_state.block<2, 3>(row, 3) = -by_world;
      by_state.block<2, 3>(row, 6) = -motion.delay * by_world;
      by_state.block<2, 3>(row, 12) = -motion.delay * by_world * hat(arm) * R;
      by_border.block(row, 0, 2, lens) =
          factor * *parameter_derivative(camera, p_cam) * by_coordinates;
      by_border.block<2, 3>(row, lens) = -factor * image->d_point * hat(turned);
      by_border.block<2, 3>(row, lens + 3) = factor * image->d_point;
      // The point moves in the IMU's frame as time goes on.
      const Vector2d by_time = by_imu * (-motion.rate.cross(p_imu) - imu_R_world * motion.v_world);
      by_border.block<2, 1>(row, lens + 6) = by_time;
      if (layout_.has_readout()) {
        by_border.block<2, 1>(row, lens + 7) = line_part(camera, view.pixels[i]) * by_time;
      }
      if (shape > 0) {
        by_border.block(row, of_camera, 2, shape) =
            by_world * input_.cameras.shape.by_parameters[static_cast<std::size_t>(view.ids[i])];
      }
      r.segment<2>(row) = w.root_weight * error;
      result.cost += w.cost;
    }
    std::vector<int> columns = columns_from(layout_.lens_row(c), of_camera);
    for (int i = 0; i < shape; ++i) columns.push_back(layout_.shape_row() + i);
    result.equations.add(k, by_state, by_border, columns, r);
    return true;
  }

  // What is known of a state at which a chain begins.
  void add_first(const InertialRig& x, std::size_t k, Linearised& result) const {
    VectorXd r(9);
    r << x.states[k].v_world / kVelocitySigma,
        x.states[k].accelerometer_bias / kAccelerometerBiasSigma,
        x.states[k].gyroscope_bias / kGyroscopeBiasSigma;
    MatrixXd J = MatrixXd::Zero(9, 15);
    J.block<3, 3>(0, 6) = Matrix3d::Identity() / kVelocitySigma;
    J.block<3, 3>(3, 9) = Matrix3d::Identity() / kAccelerometerBiasSigma;
    J.block<3, 3>(6, 12) = Matrix3d::Identity() / kGyroscopeBiasSigma;
    result.equations.add(k, J, MatrixXd(9, 0), {}, r);
    result.cost += r.squaredNorm() / 2;
  }

  void add_link(const InertialRig& x, std::size_t k, Linearised& result) const {
    const ImuLink link = chasles::corrected(x.imu, *links_[k]);
    LinkDerivatives d;
    const Vector15d r = link_residual(link, x.states[k], x.states[k + 1], x.gravity, &d);
    const double t = to_seconds(instants_[k + 1].time - instants_[k].time);
    const Matrix3d Rt = x.states[k].world_T_imu.R.transpose();
    Eigen::Matrix<double, 15, 3> by_gravity = Eigen::Matrix<double, 15, 3>::Zero();
    by_gravity.middleRows<3>(3) = -t * t / 2 * Rt;
    by_gravity.middleRows<3>(6) = -t * Rt;
    const int imu = x.imu.size();
    MatrixXd by_border(15, 2 + imu);
    by_border.leftCols<2>() = link.whitening * by_gravity * -hat(x.gravity) * across(x.gravity);
    if (imu > 0) {
      by_border.rightCols(imu) = link_by_imu(*links_[k], x.imu, x.states[k], x.states[k + 1]);
    }
    result.equations.add_link(k, d.now, d.next, by_border,
                              columns_from(layout_.gravity_row(), 2 + imu), r);
    result.cost += r.squaredNorm() / 2;
  }

  void add_prior(int row, double value, double sigma, Linearised& result) const {
    const VectorXd r = VectorXd::Constant(1, value / sigma);
    result.equations.add_border(MatrixXd::Constant(1, 1, 1 / sigma), std::vector<int>{row}, r);
    result.cost += r.squaredNorm() / 2;
  }

  void add_priors(const InertialRig& x, Linearised& result) const {
    for (std::size_t c = 0; c < layout_.cameras(); ++c) {
      for (const LensPrior& prior : lens_priors(layout_.lens(c))) {
        add_prior(layout_.lens_row(c) + prior.parameter,
                  lens_parameters(x.cameras[c])[prior.parameter] - prior.mean, prior.sigma, result);
      }
      add_prior(layout_.offset_row(c), x.offsets[c], kOffsetSigma, result);
      if (layout_.has_readout()) {
        add_prior(layout_.readout_row(c), x.cameras[c].shutter.readout - kReadoutSigma,
                  kReadoutSigma, result);
      }
    }
    const VectorXd imu = x.imu.size() > 0 ? VectorXd(x.imu.parameters()) : VectorXd(0);
    for (Eigen::Index i = 0; i < imu.size(); ++i) {
      add_prior(layout_.imu_row() + static_cast<int>(i), imu[i],
                i < ImuCorrection::kScales ? kScaleSigma : kMisalignmentSigma, result);
    }
    for (Eigen::Index i = 0; i < x.shape.size(); ++i) {
      add_prior(layout_.shape_row() + static_cast<int>(i), x.shape[i],
                input_.cameras.shape.sigma[i], result);
    }
  }

  const InertialCalibrationInput& input_;
  InertialLayout layout_;
  std::vector<InertialInstant> instants_;
  std::vector<std::optional<ImuLink>> links_;
  double sigma_;
};

// The views whose lines the IMU covers, by instants of the IMU's clock.
std::vector<InertialInstant> inertial_instants(const std::vector<ExplainedView>& views,
                                               const std::vector<ImuSample>& imu, double offset) {
  constexpr double kMargin = 0.1;  // [s]
  std::vector<InertialInstant> instants;
  const Time shift(static_cast<std::int64_t>(std::llround(1e9 * offset)));
  for (const ExplainedView& one : views) {
    const Time time = one.view.time + shift;
    if (to_seconds(time - imu.front().time) < kMargin ||
        to_seconds(imu.back().time - time) < kMargin) {
      continue;
    }
    if (instants.empty() || instants.back().time != time)
      instants.push_back({.time = time, .views = {}, .sample = {}});
    instants.back().views.push_back(&one.view);
  }
  return instants;
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

// As of the cameras alone, for the lenses: what else the corners say is eliminated.
double lens_correlation(const InertialProblem& problem, const InertialLayout& layout,
                        const InertialRig& x) {
  const std::optional<Linearised> pixels = problem.pixels_alone(x);
  if (!pixels) return 1;
  const auto gradients = pixels->equations.border_gradients();
  const auto information = pixels->equations.border_information();
  if (!gradients || !information) return 1;
  std::vector<int> lens, other;
  for (std::size_t c = 0; c < layout.cameras(); ++c) {
    for (const int row : columns_from(layout.lens_row(c), layout.lens(c).parameters())) {
      lens.push_back(row);
    }
  }
  for (int row = 0; row < layout.rows(); ++row) {
    if (!std::ranges::binary_search(lens, row)) other.push_back(row);
  }
  const MatrixXd by_other = (*information)(other, other).ldlt().solve((*information)(other, lens));
  const MatrixXd of_lens = (*information)(lens, lens) - (*information)(lens, other) * by_other;
  const MatrixXd eliminated =
      (*gradients)(lens, Eigen::all) - by_other.transpose() * (*gradients)(other, Eigen::all);
  MatrixXd scatter = MatrixXd::Zero(of_lens.rows(), of_lens.cols());
  VectorXd block = VectorXd::Zero(of_lens.rows());
  Time begin{};
  for (std::size_t k = 0; k < problem.instants().size(); ++k) {
    if (k == 0 || to_seconds(problem.instants()[k].time - begin) >= kIndependentSeconds) {
      scatter += block * block.transpose();
      block.setZero();
      begin = problem.instants()[k].time;
    }
    block += eliminated.col(static_cast<Eigen::Index>(k));
  }
  scatter += block * block.transpose();
  return std::max(1.0, of_lens.ldlt().solve(scatter).trace() / static_cast<double>(lens.size()));
}

InertialRig first_rig(const InertialCalibrationInput& input, const CamerasCalibration& alone,
                      const RotationAlignment& alignment,
                      const std::vector<InertialInstant>& instants) {
  InertialRig x{.cameras = alone.cameras,
                .offsets = std::vector<double>(alone.cameras.size(), alignment.time_offset),
                .gravity = {},
                .imu = {},
                .shape = alone.shape,
                .states = {}};
  x.imu.has_g_sensitivity = false;
  x.imu.has_scale = x.imu.has_misalignment = input.has_imu_errors;
  SE3 cam0_T_imu;  // its position follows
  cam0_T_imu.R = alignment.cam_R_imu;
  for (Camera& camera : x.cameras) {
    camera.cam_T_imu = camera.cam_T_imu * cam0_T_imu;
    if (input.has_readout) camera.shutter.readout = std::max(camera.shutter.readout, 0.001);
  }
  std::map<std::pair<Time, int>, SE3> poses;
  for (const ExplainedView& one : alone.views) {
    poses[{one.view.time, one.view.camera}] = one.cam_T_target;
  }
  ImuBuffer buffer({.convention = input.convention});
  for (const ImuSample& sample : input.imu) buffer.add(sample);
  Vector3d force = Vector3d::Zero();
  for (const InertialInstant& instant : instants) {
    const TargetView& view = *instant.views.front();
    const SE3 cam_T_target = poses.at({view.time, view.camera});
    InertialState state;
    state.world_T_imu =
        cam_T_target.inverse() * x.cameras[static_cast<std::size_t>(view.camera)].cam_T_imu;
    state.gyroscope_bias = alignment.gyroscope_bias;
    x.states.push_back(state);
    force += state.world_T_imu.R * buffer.at(instant.time)->specific_force_imu;
  }
  // Accelerations are zero in the mean.
  const double mean_force = force.norm() / static_cast<double>(instants.size());
  if (std::abs(mean_force / input.gravity - 1) > kMostForce) {
    throw InputError(fmt::format(
        "the mean of the specific force in the target's frame is {:.3g} m/s^2, expected about "
        "{:.3g}: are the samples in m/s^2, with gravity, and in the axes of the gyroscope?",
        mean_force, input.gravity));
  }
  x.gravity = -input.gravity * force.normalized();
  for (std::size_t k = 0; k < x.states.size(); ++k) {
    const std::size_t a = k > 0 ? k - 1 : k, b = k + 1 < x.states.size() ? k + 1 : k;
    const double t = to_seconds(instants[b].time - instants[a].time);
    if (t > 0 && t < kLongestLink) {
      x.states[k].v_world = (x.states[b].world_T_imu.p - x.states[a].world_T_imu.p) / t;
    }
  }
  return x;
}

RotationAlignment alignment_of(const InertialCalibrationInput& input,
                               const CamerasCalibration& alone) {
  std::vector<SeenAttitude> attitudes;  // of the first camera
  for (const ExplainedView& one : alone.views) {
    const Camera& camera = alone.cameras[static_cast<std::size_t>(one.view.camera)];
    if (!attitudes.empty() && attitudes.back().time == one.view.time) continue;
    attitudes.push_back({one.view.time, camera.cam_T_imu.R.transpose() * one.cam_T_target.R});
  }
  const auto alignment = align_rotations(attitudes, input.imu);
  if (!alignment) {
    throw InputError(
        "the IMU and the views of the target have too little time in common: expected views in "
        "quick succession, by a clock within 1 s of the IMU's, at least 10 of them");
  }
  if (alignment->unexplained > kMostUnexplained) {
    throw InputError(fmt::format(
        "the gyroscope does not turn as the cameras do: {:.0f} % of their rates are unexplained, "
        "expected less than {:.0f} %: was the target static, is the motion brisk, and are units "
        "and clocks of the IMU right (`chasles check`)?",
        100 * alignment->unexplained, 100 * kMostUnexplained));
  }
  return *alignment;
}

// A sensor that is read the other way round has a negative readout time, and its first line last.
void flip_negative_readout(Camera& camera, double& time_offset) {
  Shutter& shutter = camera.shutter;
  if (shutter.readout >= 0) return;
  using enum ReadoutDirection;
  const bool by_rows = shutter.direction == kDown || shutter.direction == kUp;
  time_offset += shutter.readout * (1 - 1.0 / (by_rows ? camera.height : camera.width));
  shutter.readout = -shutter.readout;
  shutter.direction = shutter.direction == kDown    ? kUp
                      : shutter.direction == kUp    ? kDown
                      : shutter.direction == kRight ? kLeft
                                                    : kRight;
}

VectorXd prior_sigmas(const InertialCalibrationInput& input, const InertialLayout& layout,
                      const ImuCorrection& imu) {
  VectorXd sigmas = VectorXd::Constant(layout.rows(), std::numeric_limits<double>::infinity());
  for (int i = 0; i < imu.size(); ++i) {
    sigmas[layout.imu_row() + i] = i < ImuCorrection::kScales ? kScaleSigma : kMisalignmentSigma;
  }
  sigmas.tail(layout.shape_rows()) = input.cameras.shape.sigma;
  return sigmas;
}

VectorXd inertial_values(const InertialRig& x, const InertialLayout& layout) {
  VectorXd values = VectorXd::Zero(layout.rows());
  for (std::size_t c = 0; c < layout.cameras(); ++c) {
    const Camera& camera = x.cameras[c];
    values.segment(layout.lens_row(c), layout.lens(c).parameters()) = lens_parameters(camera);
    values.segment<3>(layout.pose_row(c)) = so3::log(camera.cam_T_imu.R);
    values.segment<3>(layout.pose_row(c) + 3) = camera.cam_T_imu.p;
    values[layout.offset_row(c)] = x.offsets[c];
    if (layout.has_readout()) values[layout.readout_row(c)] = camera.shutter.readout;
  }
  if (x.imu.size() > 0) values.segment(layout.imu_row(), x.imu.size()) = x.imu.parameters();
  values.tail(layout.shape_rows()) = x.shape;
  return values;
}

}  // namespace

InertialLayout::InertialLayout(const std::vector<LensForm>& lenses, bool has_readout, int imu_rows,
                               std::vector<std::string> shape_names)
    : lenses_(lenses),
      has_readout_(has_readout),
      imu_rows_(imu_rows),
      shape_names_(std::move(shape_names)) {
  int row = 0;
  for (const LensForm& lens : lenses_) {
    first_.push_back(row);
    row += lens.parameters() + 7 + (has_readout ? 1 : 0);
  }
  first_.push_back(row);
}

std::vector<std::string> InertialLayout::names(const ImuCorrection& imu) const {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < lenses_.size(); ++c) {
    const std::string of = fmt::format("cam{}.", c);
    for (const std::string& name : lens_parameter_names(lenses_[c])) names.push_back(of + name);
    for (const char* part : {"rotation", "position"}) {
      for (const char* axis : {"_x", "_y", "_z"}) names.push_back(of + part + axis);
    }
    names.push_back(of + "time_offset");
    if (has_readout_) names.push_back(of + "readout_time");
  }
  names.insert(names.end(), {"gravity_1", "gravity_2"});
  if (imu_rows_ > 0) {
    for (const std::string& name : imu.names()) names.push_back("imu." + name);
  }
  for (const std::string& name : shape_names_) names.push_back("target." + name);
  return names;
}

InertialCalibration calibrate_inertial(const InertialCalibrationInput& input) {
  if (input.imu.size() < 2) {
    throw InputError(
        fmt::format("found {} IMU samples, expected a recording with an IMU", input.imu.size()));
  }
  CamerasCalibration alone = calibrate_cameras(input.cameras);
  const RotationAlignment alignment = alignment_of(input, alone);
  ImuCorrection imu;
  imu.has_g_sensitivity = false;
  imu.has_scale = imu.has_misalignment = input.has_imu_errors;
  const InertialLayout layout(input.cameras.lenses, input.has_readout, imu.size(),
                              input.cameras.shape.names);
  double offset = alignment.time_offset;
  InertialProblem problem(input, layout, inertial_instants(alone.views, input.imu, offset),
                          alone.pixel_sigma);
  InertialRig x = first_rig(input, alone, alignment, problem.instants());
  int iterations = 0;
  double gyroscope = 1, accelerometer = 1, sigma = alone.pixel_sigma, correlation = 1;
  constexpr int kRounds = 5;
  for (int round = 0; round < kRounds; ++round) {
    problem.make_links(x, gyroscope, accelerometer);
    const auto found = minimised(
        x, [&](const InertialRig& rig) { return problem.linearised(rig); },
        [&](const InertialRig& rig, const ChainEquations::Step& step) {
          return problem.moved(rig, step);
        });
    if (!found) throw InputError("a lens cannot have the corners where they were found");
    x = found->state;
    iterations += found->iterations;
    const bool is_last = round + 1 == kRounds;
    if (is_last && !found->converged) {
      throw InputError(fmt::format(
          "the search did not converge in {} steps: the motion does not determine all parameters; "
          "expected quick turns about all three axes and quick shifts, with the target in view",
          iterations));
    }
    if (is_last) break;
    // The noise that the residuals show.
    const auto [rotation, motion] = problem.link_squares(x);
    gyroscope = std::max(1.0, gyroscope * std::sqrt(rotation));
    accelerometer = std::max(1.0, accelerometer * std::sqrt(motion));
    sigma = inertial_scatter(problem, x);
    problem.set_sigma(sigma);
    correlation = lens_correlation(problem, layout, x);
    problem.set_sigma(sigma * std::sqrt(correlation));
    if (std::abs(x.offsets[0] - offset) > kStale) {
      // The states move to the times that the offset states now.
      const double change = x.offsets[0] - offset;
      offset = x.offsets[0];
      for (std::size_t k = 0; k < x.states.size(); ++k) {
        const Motion later(x.states[k], x, problem.instants()[k], change);
        x.states[k].world_T_imu = later.world_T_imu;
        x.states[k].v_world = later.v_world;
      }
      std::vector<InertialInstant> instants = inertial_instants(alone.views, input.imu, offset);
      if (instants.size() != x.states.size()) {
        throw InputError("the IMU does not cover the views at the time offset that was found");
      }
      problem.set_instants(std::move(instants));
    }
  }
  const std::optional<Linearised> linearised = problem.linearised(x);
  const std::optional<MatrixXd> information = linearised->equations.border_information();
  const Eigen::LLT<MatrixXd> factor(information.value_or(MatrixXd::Zero(1, 1)));
  if (!information || factor.info() != Eigen::Success) {
    throw InputError("the motion does not determine all parameters: expected turns about all axes");
  }
  MatrixXd T = MatrixXd::Identity(layout.rows(), layout.rows());
  for (std::size_t c = 0; c < layout.cameras(); ++c) {
    const int row = layout.lens_row(c), n = layout.lens(c).parameters();
    T.block(row, row, n, n) = by_search_coordinates(
        layout.lens(c), search_coordinates(layout.lens(c), lens_parameters(x.cameras[c])));
  }
  InertialCalibration result{
      .cameras = x.cameras,
      .time_offsets = x.offsets,
      .gravity_target = x.gravity,
      .imu = x.imu,
      .biases = Vector6d::Zero(),
      .shape = x.shape,
      .names = layout.names(x.imu),
      .values = inertial_values(x, layout),
      .covariance = {},
      .layout = layout,
      .alone = std::move(alone),
      .pixel_sigma = sigma,
      .correlation_factor = correlation,
      .gyroscope_factor = gyroscope,
      .accelerometer_factor = accelerometer,
      .instants = problem.instants().size(),
      .seconds = to_seconds(problem.instants().back().time - problem.instants().front().time),
      .iterations = iterations,
      .views = {}};
  result.prior_sigmas = prior_sigmas(input, layout, x.imu);
  for (int i = 0; i < std::min(x.imu.size(), ImuCorrection::kScales); ++i) {
    const int row = layout.imu_row() + i;
    if (std::abs(result.values[row]) <= kMostScaleSigmas * result.prior_sigmas[row]) continue;
    throw InputError(fmt::format(
        "{} would be {:.3g}, expected {:.2g} at most: are units and axes of the IMU, and the size "
        "of the target, right?",
        result.names[static_cast<std::size_t>(row)], result.values[row],
        kMostScaleSigmas * result.prior_sigmas[row]));
  }
  for (std::size_t c = 0; layout.has_readout() && c < result.cameras.size(); ++c) {
    flip_negative_readout(result.cameras[c], result.time_offsets[c]);
  }
  result.covariance =
      T * factor.solve(MatrixXd::Identity(layout.rows(), layout.rows())) * T.transpose();
  for (std::size_t k = 0; k < x.states.size(); ++k) {
    result.biases += x.states[k].biases() / static_cast<double>(x.states.size());
    for (const TargetView* view : problem.instants()[k].views) {
      ExplainedView one{
          .view = *view,
          .cam_T_target = x.cameras[static_cast<std::size_t>(view->camera)].cam_T_imu *
                          x.states[k].world_T_imu.inverse(),
          .errors = problem.errors(x, k, *view),
          .rms = 0};
      for (const Vector2d& error : one.errors) one.rms += error.squaredNorm();
      one.rms =
          std::sqrt(one.rms / static_cast<double>(std::max<std::size_t>(1, one.errors.size())));
      result.views.push_back(std::move(one));
    }
  }
  return result;
}

}  // namespace chasles
