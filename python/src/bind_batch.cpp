#include <pybind11/stl.h>

#include <chasles/smooth/batch/batch_terms.hpp>

#include "arrays.hpp"
#include "module.hpp"

// The problem of batch estimation as columns (chasles.interop.batch_problem documents them).
namespace chasles::python {
namespace {

using Eigen::Index;

py::dict keyframes_of(const std::vector<TimedMotion>& keyframes) {
  const auto n = static_cast<Index>(keyframes.size());
  Trajectory path;
  Rows velocity(n, 3), accelerometer(n, 3), gyroscope(n, 3);
  for (Index k = 0; k < n; ++k) {
    const auto& [time, state] = keyframes[static_cast<std::size_t>(k)];
    path.push_back({.time = time, .pose = state.world_T_imu});
    velocity.row(k) = state.v_world;
    accelerometer.row(k) = state.accelerometer_bias;
    gyroscope.row(k) = state.gyroscope_bias;
  }
  py::dict result = columns(path);
  result["velocity"] = std::move(velocity);
  result["accelerometer_bias"] = std::move(accelerometer);
  result["gyroscope_bias"] = std::move(gyroscope);
  return result;
}

py::dict start_of(const BatchTerms& terms) {
  const InertialState& state = terms.start;
  py::dict result;
  result["position"] = Eigen::Vector3d(state.world_T_imu.p);
  result["quaternion"] = quaternion_xyzw(state.world_T_imu.R);
  result["velocity"] = state.v_world;
  result["accelerometer_bias"] = state.accelerometer_bias;
  result["gyroscope_bias"] = state.gyroscope_bias;
  result["covariance"] = Rows(terms.start_covariance);
  return result;
}

py::dict samples_of(const std::vector<std::vector<ImuInterval>>& between) {
  std::size_t count = 0;
  for (const auto& list : between) count += list.size();
  const auto n = static_cast<Index>(count);
  Times keyframe(n);
  Eigen::VectorXd tau(n), scale(n), accelerometer(n), gyroscope(n);
  Rows force(n, 3), rate(n, 3);
  Index i = 0;
  for (std::size_t k = 0; k < between.size(); ++k) {
    for (const ImuInterval& interval : between[k]) {
      keyframe[i] = static_cast<std::int64_t>(k);
      tau[i] = interval.tau;
      force.row(i) = interval.specific_force_imu;
      rate.row(i) = interval.angular_rate_imu;
      scale[i] = interval.noise_scale;
      accelerometer[i] = interval.accelerometer_extra_density;
      gyroscope[i++] = interval.gyroscope_extra_density;
    }
  }
  py::dict result;
  result["keyframe"] = std::move(keyframe);
  result["tau"] = std::move(tau);
  result["specific_force"] = std::move(force);
  result["angular_rate"] = std::move(rate);
  result["noise_scale"] = std::move(scale);
  result["accelerometer_extra_density"] = std::move(accelerometer);
  result["gyroscope_extra_density"] = std::move(gyroscope);
  return result;
}

py::dict landmarks_of(const BatchTerms& terms) {
  const auto n = static_cast<Index>(terms.points.size());
  Times id(n);
  Rows position(n, 3);
  for (Index i = 0; i < n; ++i) {
    id[i] = terms.points[static_cast<std::size_t>(i)].id;
    position.row(i) = terms.points[static_cast<std::size_t>(i)].p_nav;
  }
  py::dict result;
  result["id"] = std::move(id);
  result["position"] = std::move(position);
  return result;
}

py::dict views_of(const BatchTerms& terms) {
  std::size_t count = 0;
  for (const BatchTerms::Point& point : terms.points) count += point.views.size();
  const auto n = static_cast<Index>(count);
  Times landmark(n), keyframe(n), camera(n);
  Rows pixel(n, 2);
  Eigen::VectorXd sigma(n), delay(n);
  Index i = 0;
  for (std::size_t l = 0; l < terms.points.size(); ++l) {
    for (const BatchTerms::View& view : terms.points[l].views) {
      landmark[i] = static_cast<std::int64_t>(l);
      keyframe[i] = view.keyframe;
      camera[i] = view.camera;
      pixel.row(i) = view.pixel;
      delay[i] = view.delay;
      sigma[i++] = view.sigma;
    }
  }
  py::dict result;
  result["landmark"] = std::move(landmark);
  result["keyframe"] = std::move(keyframe);
  result["camera"] = std::move(camera);
  result["pixel"] = std::move(pixel);
  result["sigma"] = std::move(sigma);
  result["delay"] = std::move(delay);
  return result;
}

py::dict problem_of(const BatchTerms& terms) {
  py::dict result;
  result["cameras"] = terms.cameras;
  result["imu_noise"] = terms.noise;
  result["gravity"] = terms.gravity;
  result["start"] = start_of(terms);
  result["keyframes"] = keyframes_of(terms.keyframes);
  result["samples"] = samples_of(terms.between);
  result["landmarks"] = landmarks_of(terms);
  result["views"] = views_of(terms);
  result["landmarks_beyond_infinity"] = terms.beyond_infinity;
  result["loss"] = std::string(name_of(terms.loss));
  result["loss_width"] = terms.loss_width;
  result["cost"] = terms.cost;
  result["inverse_depth_sigma"] = terms.inverse_depth_sigma;
  result["inverse_depth_cost"] = terms.inverse_depth_cost;
  result["calibration_cost"] = terms.calibration_cost;
  return result;
}

}  // namespace

py::list problems_of(const std::vector<std::shared_ptr<const BatchTerms>>& parts) {
  py::list result;
  for (const auto& terms : parts) result.append(problem_of(*terms));
  return result;
}

}  // namespace chasles::python
